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
  uint32_t index;
  before = allocations;
  const fb_status single = fb_evaluate(model, scratch, controls, positions);
  const fb_status batch = fb_evaluate_batch(model, scratch, &desc);
  const fb_status others = fb_evaluate_batch(model, scratch, &other);
  const fb_status weights = fb_evaluate_coefficients(model, scratch, controls, coefficients);
  const fb_status found = fb_find_control(model, "jaw_open", &index);
  const long during = allocations - before;
  assert_ok(single);
  assert_ok(batch);
  assert_ok(others);
  assert_ok(weights);
  assert_ok(found);
  assert_int_equal(during, 0);
  fb_scratch_destroy(scratch);
  fb_release(model);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(evaluating_allocates_nothing)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
