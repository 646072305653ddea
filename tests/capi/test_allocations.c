/* Evaluating takes no memory: this program replaces the allocation functions of the C library by counting ones. */
#include "capi_test.h"

#include <errno.h>
#include <stdlib.h>

extern void* __libc_malloc(size_t bytes);
extern void* __libc_calloc(size_t count, size_t bytes);
extern void* __libc_realloc(void* memory, size_t bytes);
extern void* __libc_memalign(size_t alignment, size_t bytes);

static volatile long allocations;

void* malloc(size_t bytes) {
  ++allocations;
  return __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  ++allocations;
  return __libc_calloc(count, bytes);
}
void* realloc(void* memory, size_t bytes) {
  ++allocations;
  return __libc_realloc(memory, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  ++allocations;
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
  ++allocations;
  *memory = __libc_memalign(alignment, bytes);
  return *memory ? 0 : ENOMEM;
}

static void serial(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  (void)user;
  for (uint32_t i = 0; i < count; ++i) task(context, i, i % workers);
}

static void evaluating_allocates_nothing(void** state) {
  (void)state;
  long before = allocations;
  fb_model* model = load_tiny();
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 2, &scratch));
  assert_true(allocations > before); /* the counter works */

  static float controls[4 * 5], positions[4 * 90];
  for (int i = 0; i < 20; ++i) controls[i] = 0.1f * (float)i;
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = 4;
  desc.controls = controls;
  desc.control_floats = 20;
  desc.positions = positions;
  desc.position_floats = 360;
  static float normals[4 * 90], tangents[4 * 90], coefficients[64];
  assert_true(fb_coefficient_count(model) <= 64);
  desc.normals = normals;
  desc.normal_numbers = 360;
  desc.tangents = tangents;
  desc.tangent_numbers = 360;
  desc.parallel_for = serial;
  const uint32_t region = 0;
  fb_batch_desc other = desc;
  other.format = FB_FLOAT16;
  other.vertex_order = FB_ORDER_BAKED;
  other.regions = &region;
  other.region_count = 1;
  static int16_t quantised[4 * 256];
  assert_true(fb_digit_column_count(model) <= 256);
  fb_quantised_desc whole;
  fb_quantised_desc_init(&whole);
  whole.poses = 4;
  whole.controls = controls;
  whole.control_floats = 20;
  whole.quantised = quantised;
  whole.quantised_numbers = 4 * 256;
  uint32_t index;
  before = allocations;
  const fb_status single = fb_evaluate(model, scratch, controls, positions);
  const fb_status batch = fb_evaluate_batch(model, scratch, &desc);
  const fb_status others = fb_evaluate_batch(model, scratch, &other);
  const fb_status weights = fb_evaluate_coefficients(model, scratch, controls, coefficients);
  const fb_status integers = fb_evaluate_quantised(model, scratch, &whole);
  const fb_status found = fb_find_control(model, "jaw_open", &index);
  const long during = allocations - before;
  assert_ok(single);
  assert_ok(batch);
  assert_ok(others);
  assert_ok(weights);
  assert_ok(integers);
  assert_ok(found);
  assert_int_equal(during, 0);
  fb_scratch_destroy(scratch);
  fb_release(model);
}

/* A host's allocator, whose blocks the counter above does not count. */
typedef struct Host {
  long calls;
  size_t bytes, peak; /* in use */
} Host;
static void* allocate_of_host(void* user, size_t bytes, size_t alignment) {
  Host* host = user;
  ++host->calls;
  host->bytes += bytes;
  if (host->bytes > host->peak) host->peak = host->bytes;
  return __libc_memalign(alignment, bytes);
}
static void release_to_host(void* user, void* memory, size_t bytes, size_t alignment) {
  (void)alignment;
  ((Host*)user)->bytes -= bytes;
  free(memory);
}
static fb_model* load_from(Host* host, const char* path) {
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.allocator.user = host;
  desc.allocator.allocate = allocate_of_host;
  desc.allocator.release = release_to_host;
  fb_model* model = NULL;
  assert_ok(fb_load(path, &desc, &model));
  return model;
}

static void loading_allocates_seldom_and_from_the_host(void** state) {
  (void)state;
  const char* const paths[] = {FB_FIXTURE, FB_CHARACTER, FB_LEVELS, FB_DRIVEN, FB_BODY};
  for (int i = 0; i < 5; ++i) {
    Host host = {0, 0, 0};
    const long before = allocations;
    fb_model* model = load_from(&host, paths[i]);
    /* Names, handles and the mesh while it is decoded. */
    assert_true(allocations - before + host.calls <= 500);
    assert_true(host.calls > 0 && host.peak >= fb_runtime_bytes(model));
    fb_release(model);
    assert_int_equal(host.bytes, 0);
  }
}

/* Faces that share the scratches of threads take no memory but their outputs. */
static void instances_take_no_memory(void** state) {
  (void)state;
  enum { instances = 100, controls = 5, floats = 90 };
  Host host = {0, 0, 0};
  fb_model* model = load_from(&host, FB_FIXTURE);
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create_single(model, 2, &scratch));
  static float poses[instances][controls], positions[instances][floats], normals[instances][floats];
  static fb_batch_desc batches[instances];
  static fb_many_item items[instances];
  for (int i = 0; i < instances; ++i) {
    for (int c = 0; c < controls; ++c) poses[i][c] = 0.01f * (float)(i + c);
    fb_batch_desc_init(&batches[i]);
    batches[i].poses = 1;
    batches[i].controls = poses[i];
    batches[i].control_floats = controls;
    batches[i].positions = positions[i];
    batches[i].normals = normals[i];
    batches[i].position_floats = batches[i].normal_numbers = floats;
    items[i].model = model;
    items[i].batch = &batches[i];
  }
  fb_many_desc desc;
  fb_many_desc_init(&desc);
  desc.items = items;
  desc.item_count = instances;
  desc.scratches = &scratch;
  desc.scratch_count = 1;
  desc.parallel_for = serial;
  const long before = allocations + host.calls;
  const size_t bytes = host.bytes;
  const fb_status status = fb_evaluate_many(&desc, NULL);
  const long during = allocations + host.calls - before;
  assert_ok(status);
  assert_int_equal(during, 0);
  assert_int_equal(host.bytes, bytes);
  fb_scratch_destroy(scratch);
  fb_release(model);
  assert_int_equal(host.bytes, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(evaluating_allocates_nothing),
                                     cmocka_unit_test(loading_allocates_seldom_and_from_the_host),
                                     cmocka_unit_test(instances_take_no_memory)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
