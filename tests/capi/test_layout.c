/* Structs that cross the boundary: defaults, sizes of older and newer hosts; names of statuses, the version. The
 * layouts that bindings take structs to have are compiled in, see fb_assert_layouts. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <stdlib.h>
#include <string.h>

static void init_functions_set_sizes_and_defaults(void** state) {
  (void)state;
  fb_load_desc load;
  fb_load_desc_init(&load);
  assert_int_equal(load.struct_size, sizeof load);
  assert_true(load.max_file_bytes == (uint64_t)4 << 30);
  assert_true(load.max_model_bytes == (uint64_t)4 << 30);
  assert_true(load.max_name_bytes == (uint64_t)16 << 20 && load.max_vertices == (uint64_t)4 << 20);
  assert_true(load.max_polygons == (uint64_t)8 << 20 && load.max_features == (uint64_t)1 << 20);
  assert_true(load.allocator.allocate == NULL && load.log == NULL && load.map_file == 0);
  assert_true(load.threads == 1 && load.parallel_for == NULL);
  fb_control control;
  fb_control_init(&control);
  assert_int_equal(control.struct_size, sizeof control);
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  assert_int_equal(batch.struct_size, sizeof batch);
  assert_true(batch.poses == 0 && batch.controls == NULL);
  fb_row_block group;
  fb_row_block_init(&group);
  assert_int_equal(group.struct_size, sizeof group);
  assert_true(group.first_row == 0 && group.row_count == 0 && group.column_count == 0);
  fb_row_block_init(NULL);
  fb_load_desc_init(NULL);
  fb_control_init(NULL);
  fb_batch_desc_init(NULL);
}

static void structs_of_other_headers_are_filled_to_their_size(void** state) {
  (void)state;
  fb_load_desc older;
  memset(&older, 0x5a, sizeof older);
  fb_load_desc_fill(&older, offsetof(fb_load_desc, allocator));
  assert_int_equal(older.struct_size, offsetof(fb_load_desc, allocator));
  assert_true(older.max_model_bytes == (uint64_t)4 << 30);
  const unsigned char* beyond = (const unsigned char*)&older.allocator;
  for (size_t i = 0; i < sizeof older - offsetof(fb_load_desc, allocator); ++i) assert_int_equal(beyond[i], 0x5a);

  struct {
    fb_batch_desc batch;
    uint64_t later;
  } newer;
  memset(&newer, 0x5a, sizeof newer);
  fb_batch_desc_fill(&newer.batch, sizeof newer);
  assert_int_equal(newer.batch.struct_size, sizeof newer);
  assert_true(newer.batch.poses == 0 && newer.later == 0);
}

static void statuses_have_names(void** state) {
  (void)state;
  assert_string_equal(fb_status_name(FB_OK), "FB_OK");
  assert_string_equal(fb_status_name(FB_ERROR_INVALID_ARGUMENT), "FB_ERROR_INVALID_ARGUMENT");
  assert_string_equal(fb_status_name(FB_ERROR_INTERNAL), "FB_ERROR_INTERNAL");
  for (fb_status status = 0; status <= FB_ERROR_INTERNAL; ++status)
    assert_memory_equal(fb_status_name(status), "FB_", 3);
  assert_string_equal(fb_status_name(-1), "unknown status");
  assert_string_equal(fb_status_name(FB_ERROR_INTERNAL + 1), "unknown status");
}

static void version_as_string_and_number_agree(void** state) {
  (void)state;
  const unsigned version = fb_version();
  unsigned parts[3];
  char* next = (char*)fb_version_string();
  for (int i = 0; i < 3; ++i) {
    parts[i] = (unsigned)strtoul(next, &next, 10);
    next += *next == '.';
  }
  assert_int_equal(*next, '\0');
  assert_int_equal(version, parts[0] * 1000000 + parts[1] * 1000 + parts[2]);
  assert_true(fb_format_version() > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(init_functions_set_sizes_and_defaults),
      cmocka_unit_test(structs_of_other_headers_are_filled_to_their_size),
      cmocka_unit_test(statuses_have_names),
      cmocka_unit_test(version_as_string_and_number_agree),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
