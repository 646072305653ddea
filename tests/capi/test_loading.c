#include "capi_test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned char* fixture;
static size_t fixture_size;

static int read_fixture(void** state) {
  (void)state;
  FILE* file = fopen(FB_FIXTURE, "rb");
  if (!file) return -1;
  fixture = malloc(1 << 20);
  fixture_size = fread(fixture, 1, 1 << 20, file);
  return fclose(file);
}

static int free_fixture(void** state) {
  (void)state;
  free(fixture);
  return 0;
}

static void assert_refused(fb_status got, fb_status expected, const char* message_part) {
  assert_int_equal(got, expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("\"%s\" does not contain \"%s\"", fb_last_error(), message_part);
}

static void what_is_in_a_model(void** state) {
  (void)state;
  fb_model* model = load_tiny();
  assert_string_equal(fb_name(model), "tiny");
  assert_string_equal(fb_units(model), "cm");
  assert_string_equal(fb_up_axis(model), "y");
  assert_string_equal(fb_provenance(model), "{\"recipe\":\"tiny\"}");
  assert_int_equal(fb_vertex_count(model), 30);
  assert_int_equal(fb_control_count(model), 5);
  assert_int_equal(fb_coefficient_count(model), 5);
  assert_int_equal(fb_polygon_count(model), 21);
  assert_int_equal(fb_polygon_sizes(model)[18], 4);
  assert_int_equal(fb_polygon_sizes(model)[19], 3);
  assert_int_equal(fb_polygon_sizes(model)[20], 5);
  assert_int_equal(fb_polygon_corner_count(model), 19 * 4 + 3 + 5);
  assert_int_equal(fb_polygon_corners(model)[0], 0);
  assert_int_equal(fb_polygon_corners(model)[fb_polygon_corner_count(model) - 1], 17);
  assert_int_equal(fb_uv_count(model), 60);
  assert_true(fb_uvs(model)[0] == 0.05f * fb_rest_positions(model)[0]);
  assert_int_equal(fb_uv_corners(model)[0], 0);
  assert_true(fb_tangent_signs(model)[0] == 1 || fb_tangent_signs(model)[0] == -1);
  assert_int_equal(fb_uv_corners(model)[fb_polygon_corner_count(model) - 1], 30 + 17);
  assert_true(fb_diagonal(model) > 6 && fb_diagonal(model) < 7);
  assert_true(fb_rest_controls(model)[2] == 0.25f);
  assert_true(fb_rest_positions(model)[1] == 0);
  assert_true(fb_runtime_bytes(model) > 30 * 3 * sizeof(float));

  fb_control control;
  fb_control_init(&control);
  assert_ok(fb_control_at(model, 2, &control));
  assert_string_equal(control.name, "brow_raise");
  assert_string_equal(control.group, "brow");
  assert_true(control.minimum == 0 && control.maximum == 1 && control.rest == 0.25f);
  assert_ok(fb_control_at(model, 4, &control));
  assert_string_equal(control.group, "");
  assert_refused(fb_control_at(model, 5, &control), FB_ERROR_INVALID_ARGUMENT, "5");
  fb_release(model);
}

static void controls_are_found_by_name(void** state) {
  (void)state;
  fb_model* model = load_tiny();
  uint32_t index = 77;
  assert_ok(fb_find_control(model, "lid_close", &index));
  assert_int_equal(index, 3);
  assert_refused(fb_find_control(model, "lid_clsoe", &index), FB_ERROR_NOT_FOUND, "\"lid_close\"");
  assert_int_equal(index, 3);
  fb_release(model);
}

static void a_struct_of_another_size_is_respected(void** state) {
  (void)state;
  fb_model* model = load_tiny();
  /* An older host: the fields after `maximum` are not its own to be written. */
  fb_control control;
  fb_control_init(&control);
  control.struct_size = offsetof(fb_control, rest);
  control.rest = 77;
  assert_ok(fb_control_at(model, 2, &control));
  assert_true(control.maximum == 1 && control.rest == 77);
  assert_int_equal(control.struct_size, offsetof(fb_control, rest));
  /* A newer host: what this library does not know stays as it was. */
  struct {
    fb_control control;
    uint64_t newer;
  } larger = {.newer = 77};
  larger.control.struct_size = sizeof larger;
  assert_ok(fb_control_at(model, 2, &larger.control));
  assert_true(larger.control.rest == 0.25f && larger.newer == 77);
  assert_int_equal(larger.control.struct_size, sizeof larger);
  control.struct_size = 0;
  assert_refused(fb_control_at(model, 2, &control), FB_ERROR_INVALID_ARGUMENT, "struct_size");
  fb_release(model);

  /* A field beyond struct_size is not read: this limit would refuse the file. */
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.max_file_bytes = 1;
  desc.struct_size = offsetof(fb_load_desc, max_file_bytes);
  assert_ok(fb_load(FB_FIXTURE, &desc, &model));
  fb_release(model);
  desc.struct_size = 4;
  assert_refused(fb_load(FB_FIXTURE, &desc, &model), FB_ERROR_INVALID_ARGUMENT, "struct_size");
}

static void files_that_are_no_archive_are_refused(void** state) {
  (void)state;
  fb_model* untouched = (fb_model*)&fixture;
  fb_model* model = untouched;
  assert_refused(fb_load("/nowhere/face.fbk", NULL, &model), FB_ERROR_NOT_FOUND, "/nowhere/face.fbk");
  assert_refused(fb_load("/", NULL, &model), FB_ERROR_IO, "directory");
  assert_refused(fb_load(FB_TEXT_FILE, NULL, &model), FB_ERROR_NOT_AN_ARCHIVE, FB_TEXT_FILE);
  assert_refused(fb_load_memory("GIF89a", 6, NULL, &model), FB_ERROR_NOT_AN_ARCHIVE, "");
  assert_refused(fb_load_memory("", 0, NULL, &model), FB_ERROR_NOT_AN_ARCHIVE, "");
  assert_ptr_equal(model, untouched);
  assert_true(strlen(fb_last_error()) > 0);
}

static void every_prefix_of_an_archive_is_refused(void** state) {
  (void)state;
  fb_model* model = NULL;
  for (size_t size = 0; size < fixture_size; ++size) {
    const fb_status status = fb_load_memory(fixture, size, NULL, &model);
    assert_true(status == FB_ERROR_CORRUPT || status == FB_ERROR_NOT_AN_ARCHIVE);
    assert_null(model);
  }
  assert_ok(fb_load_memory(fixture, fixture_size, NULL, &model));
  fb_release(model);
}

static void limits_are_kept(void** state) {
  (void)state;
  fb_model* model = NULL;
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.max_file_bytes = fixture_size - 1;
  assert_refused(fb_load(FB_FIXTURE, &desc, &model), FB_ERROR_LIMIT, "limit");
  fb_load_desc_init(&desc);
  desc.max_model_bytes = 100;
  assert_refused(fb_load_memory(fixture, fixture_size, &desc, &model), FB_ERROR_LIMIT, "");
  assert_null(model);
}

static void each_number_of_items_has_a_limit(void** state) {
  (void)state;
  const struct {
    size_t field;
    uint64_t count;
    const char* what;
  } limits[] = {{offsetof(fb_load_desc, max_name_bytes), 98, "bytes of names and texts"},
                {offsetof(fb_load_desc, max_vertices), 30, "30 vertices"},
                {offsetof(fb_load_desc, max_polygons), 21, "21 polygons"},
                {offsetof(fb_load_desc, max_features), 9, "9 features"}};
  for (int i = 0; i < 4; ++i) {
    fb_model* model = NULL;
    fb_load_desc desc;
    fb_load_desc_init(&desc);
    memcpy((char*)&desc + limits[i].field, &limits[i].count, sizeof(uint64_t));
    assert_ok(fb_load_memory(fixture, fixture_size, &desc, &model));
    fb_release(model);
    model = NULL;
    const uint64_t one_less = limits[i].count - 1;
    memcpy((char*)&desc + limits[i].field, &one_less, sizeof one_less);
    assert_refused(fb_load_memory(fixture, fixture_size, &desc, &model), FB_ERROR_LIMIT, limits[i].what);
    assert_null(model);
  }
}

// A scheduler that runs tasks last to first, and counts its calls, or leaves out the first.
struct scheduler {
  int calls, faulty;
};
static void backwards(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  struct scheduler* scheduler = user;
  ++scheduler->calls;
  for (uint32_t i = count; i-- > (scheduler->faulty ? 1u : 0u);) task(context, i, i % workers);
}

static void pose(fb_model* model, const float* controls, float* positions) {
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 1, &scratch));
  assert_ok(fb_evaluate(model, scratch, controls, positions));
  fb_scratch_destroy(scratch);
}

static void a_basis_decodes_alike_on_any_threads(void** state) {
  (void)state;
  fb_model* model = NULL;
  assert_ok(fb_load_memory(fixture, fixture_size, NULL, &model));
  float alone[3 * 100], threaded[3 * 100], controls[16];
  const uint32_t count = 3 * fb_vertex_count(model);
  assert_true(count <= 3 * 100 && fb_control_count(model) <= 16);
  for (uint32_t i = 0; i < 16; ++i) controls[i] = 0.125f * (float)i;
  pose(model, controls, alone);
  fb_release(model);

  struct scheduler scheduler = {0, 0};
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  for (uint32_t threads = 0; threads < 6; ++threads) {
    desc.threads = threads;
    desc.parallel_for = threads % 2 ? backwards : NULL;
    desc.parallel_user = &scheduler;
    assert_ok(fb_load_memory(fixture, fixture_size, &desc, &model));
    pose(model, controls, threaded);
    assert_memory_equal(threaded, alone, count * sizeof(float));
    fb_release(model);
  }
  assert_int_equal(scheduler.calls, 2);  // with 3 and 5 threads

  model = NULL;
  scheduler.faulty = 1;
  assert_refused(fb_load_memory(fixture, fixture_size, &desc, &model), FB_ERROR_INVALID_ARGUMENT, "parallel_for");
  assert_null(model);
}

static void long_messages_are_cut_within_the_buffer(void** state) {
  (void)state;
  fb_model* model = NULL;
  char name[8000];
  memset(name, 0, sizeof name);
  for (size_t i = 0; i + 3 < sizeof name; i += 2) memcpy(name + i, "\xc3\xa4", 2);
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.instruction_set = name;
  assert_int_not_equal(fb_load(FB_FIXTURE, &desc, &model), FB_OK);
  const char* message = fb_last_error();
  assert_true(strlen(message) >= 2046 && strlen(message) <= 2047);
  assert_int_equal((unsigned char)message[strlen(message) - 1], 0xa4);
}

static void null_pointers_are_refused(void** state) {
  (void)state;
  fb_model* model = NULL;
  fb_control control;
  fb_scratch* scratch = NULL;
  uint32_t index;
  fb_control_init(&control);
  assert_refused(fb_load(NULL, NULL, &model), FB_ERROR_INVALID_ARGUMENT, "path");
  assert_refused(fb_load(FB_FIXTURE, NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "model");
  assert_refused(fb_load_memory(NULL, 0, NULL, &model), FB_ERROR_INVALID_ARGUMENT, "bytes");
  assert_refused(fb_load_memory(fixture, fixture_size, NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "model");
  assert_refused(fb_control_at(NULL, 0, &control), FB_ERROR_INVALID_ARGUMENT, "model");
  assert_refused(fb_find_control(NULL, "x", &index), FB_ERROR_INVALID_ARGUMENT, "model");
  assert_refused(fb_scratch_create(NULL, 1, &scratch), FB_ERROR_INVALID_ARGUMENT, "model");
  fb_retain(NULL);
  fb_release(NULL);
  fb_scratch_destroy(NULL);
  assert_true(fb_vertex_count(NULL) == 0 && fb_control_count(NULL) == 0 && fb_coefficient_count(NULL) == 0);
  assert_true(fb_polygon_count(NULL) == 0 && fb_polygon_corner_count(NULL) == 0 && fb_runtime_bytes(NULL) == 0);
  assert_true(fb_diagonal(NULL) == 0 && fb_clamped_count(NULL) == 0);
  assert_null(fb_name(NULL));
  assert_null(fb_units(NULL));
  assert_null(fb_up_axis(NULL));
  assert_null(fb_provenance(NULL));
  assert_null(fb_rest_controls(NULL));
  assert_null(fb_rest_positions(NULL));
  assert_null(fb_polygon_sizes(NULL));
  assert_null(fb_polygon_corners(NULL));
  assert_int_equal(fb_uv_count(NULL), 0);
  assert_null(fb_uvs(NULL));
  assert_null(fb_uv_corners(NULL));
  assert_null(fb_tangent_signs(NULL));

  model = load_tiny();
  assert_refused(fb_control_at(model, 0, NULL), FB_ERROR_INVALID_ARGUMENT, "control");
  assert_refused(fb_find_control(model, NULL, &index), FB_ERROR_INVALID_ARGUMENT, "name");
  assert_refused(fb_find_control(model, "jaw_open", NULL), FB_ERROR_INVALID_ARGUMENT, "index");
  assert_refused(fb_scratch_create(model, 1, NULL), FB_ERROR_INVALID_ARGUMENT, "scratch");
  assert_refused(fb_scratch_create(model, 0, &scratch), FB_ERROR_INVALID_ARGUMENT, "workers");
  fb_release(model);
}

/* An allocator that counts, and refuses once `left` blocks are given out. */
typedef struct Counter {
  int left, live;
  size_t bytes, all_bytes;
} Counter;

#ifdef _WIN32
static void* allocate_aligned(size_t bytes, size_t alignment) {
  return _aligned_malloc(bytes, alignment);
}
static void free_aligned(void* memory) {
  _aligned_free(memory);
}
#else
static void* allocate_aligned(size_t bytes, size_t alignment) {
  void* memory = NULL;
  return posix_memalign(&memory, alignment, bytes) == 0 ? memory : NULL;
}
static void free_aligned(void* memory) {
  free(memory);
}
#endif

static void* count_allocate(void* user, size_t bytes, size_t alignment) {
  Counter* counter = user;
  if (counter->left-- <= 0) return NULL;
  void* const memory = allocate_aligned(bytes, alignment < sizeof(void*) ? sizeof(void*) : alignment);
  if (!memory) return NULL;
  ++counter->live;
  counter->bytes += bytes;
  counter->all_bytes += bytes;
  return memory;
}

static void count_release(void* user, void* memory, size_t bytes, size_t alignment) {
  (void)alignment;
  Counter* counter = user;
  --counter->live;
  counter->bytes -= bytes;
  free_aligned(memory);
}

static void the_injected_allocator_is_used_and_balanced(void** state) {
  (void)state;
  Counter counter = {1000, 0, 0, 0};
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.allocator.user = &counter;
  desc.allocator.allocate = count_allocate;
  assert_null(desc.allocator.release);
  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  assert_refused(fb_load(FB_FIXTURE, &desc, &model), FB_ERROR_INVALID_ARGUMENT, "allocator");
  desc.allocator.release = count_release;
  assert_ok(fb_load(FB_FIXTURE, &desc, &model));
  assert_true(counter.bytes >= fb_runtime_bytes(model));
  const size_t of_model = counter.bytes;
  assert_ok(fb_scratch_create(model, 3, &scratch));
  assert_true(counter.bytes > of_model);
  fb_release(model);
  fb_scratch_destroy(scratch);
  assert_int_equal(counter.live, 0);
  assert_int_equal(counter.bytes, 0);

  /* Out of memory at every single block. */
  const int blocks = 1000 - counter.left;
  for (int allowed = 0; allowed < blocks; ++allowed) {
    counter.left = allowed;
    model = NULL;
    fb_status status = fb_load(FB_FIXTURE, &desc, &model);
    if (status == FB_OK) {
      status = fb_scratch_create(model, 3, &scratch);
      fb_release(model);
    }
    assert_int_equal(status, FB_ERROR_OUT_OF_MEMORY);
    assert_int_equal(counter.live, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_in_a_model),
      cmocka_unit_test(controls_are_found_by_name),
      cmocka_unit_test(a_struct_of_another_size_is_respected),
      cmocka_unit_test(files_that_are_no_archive_are_refused),
      cmocka_unit_test(every_prefix_of_an_archive_is_refused),
      cmocka_unit_test(limits_are_kept),
      cmocka_unit_test(each_number_of_items_has_a_limit),
      cmocka_unit_test(a_basis_decodes_alike_on_any_threads),
      cmocka_unit_test(long_messages_are_cut_within_the_buffer),
      cmocka_unit_test(null_pointers_are_refused),
      cmocka_unit_test(the_injected_allocator_is_used_and_balanced),
  };
  return cmocka_run_group_tests(tests, read_fixture, free_fixture);
}
