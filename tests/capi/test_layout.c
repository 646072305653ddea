/* The layout of every struct that crosses the boundary, on 64-bit systems: a change here breaks hosts. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <stdlib.h>
#include <string.h>

#define assert_at(type, field, offset) assert_int_equal(offsetof(type, field), offset)

static void layout_of_runtime_structs(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_allocator), 24);
  assert_at(fb_allocator, user, 0);
  assert_at(fb_allocator, allocate, 8);
  assert_at(fb_allocator, release, 16);

  assert_int_equal(sizeof(fb_load_desc), 72);
  assert_at(fb_load_desc, struct_size, 0);
  assert_at(fb_load_desc, max_file_bytes, 8);
  assert_at(fb_load_desc, max_model_bytes, 16);
  assert_at(fb_load_desc, allocator, 24);
  assert_at(fb_load_desc, log, 48);
  assert_at(fb_load_desc, log_user, 56);
  assert_at(fb_load_desc, instruction_set, 64);

  assert_int_equal(sizeof(fb_control), 40);
  assert_at(fb_control, struct_size, 0);
  assert_at(fb_control, name, 8);
  assert_at(fb_control, group, 16);
  assert_at(fb_control, minimum, 24);
  assert_at(fb_control, maximum, 28);
  assert_at(fb_control, rest, 32);
  assert_at(fb_control, reserved_float, 36);

  assert_int_equal(sizeof(fb_row_block), 16);
  assert_at(fb_row_block, struct_size, 0);
  assert_at(fb_row_block, first_row, 4);
  assert_at(fb_row_block, row_count, 8);
  assert_at(fb_row_block, column_count, 12);

  assert_int_equal(sizeof(fb_batch_desc), 176);
  assert_at(fb_batch_desc, struct_size, 0);
  assert_at(fb_batch_desc, threads, 4);
  assert_at(fb_batch_desc, poses, 8);
  assert_at(fb_batch_desc, controls, 16);
  assert_at(fb_batch_desc, control_floats, 24);
  assert_at(fb_batch_desc, control_stride, 32);
  assert_at(fb_batch_desc, positions, 40);
  assert_at(fb_batch_desc, position_floats, 48);
  assert_at(fb_batch_desc, pose_stride, 56);
  assert_at(fb_batch_desc, vertex_stride, 64);
  assert_at(fb_batch_desc, parallel_for, 72);
  assert_at(fb_batch_desc, parallel_user, 80);
  assert_at(fb_batch_desc, vertex_order, 88);
  assert_at(fb_batch_desc, format, 92);
  assert_at(fb_batch_desc, normals, 96);
  assert_at(fb_batch_desc, normal_numbers, 104);
  assert_at(fb_batch_desc, normal_pose_stride, 112);
  assert_at(fb_batch_desc, normal_vertex_stride, 120);
  assert_at(fb_batch_desc, regions, 128);
  assert_at(fb_batch_desc, region_count, 136);
  assert_at(fb_batch_desc, tangents, 144);
  assert_at(fb_batch_desc, tangent_numbers, 152);
  assert_at(fb_batch_desc, tangent_pose_stride, 160);
  assert_at(fb_batch_desc, tangent_vertex_stride, 168);
}

static void layout_of_bake_structs(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_rig_control), 32);
  assert_at(fb_rig_control, minimum, 16);
  assert_at(fb_rig_control, maximum, 20);
  assert_at(fb_rig_control, rest, 24);

  assert_int_equal(sizeof(fb_rig_clip), 40);
  assert_at(fb_rig_clip, kind, 8);
  assert_at(fb_rig_clip, split, 12);
  assert_at(fb_rig_clip, fps, 16);
  assert_at(fb_rig_clip, frames, 24);
  assert_at(fb_rig_clip, controls, 32);

  assert_int_equal(sizeof(fb_rig), 144);
  assert_at(fb_rig, struct_size, 0);
  assert_at(fb_rig, abi, 4);
  assert_at(fb_rig, name, 8);
  assert_at(fb_rig, units, 16);
  assert_at(fb_rig, up_axis, 24);
  assert_at(fb_rig, flags, 32);
  assert_at(fb_rig, control_count, 36);
  assert_at(fb_rig, controls, 40);
  assert_at(fb_rig, vertex_count, 48);
  assert_at(fb_rig, polygon_count, 52);
  assert_at(fb_rig, rest_positions, 56);
  assert_at(fb_rig, polygon_sizes, 64);
  assert_at(fb_rig, polygon_corners, 72);
  assert_at(fb_rig, clip_count, 80);
  assert_at(fb_rig, clips, 88);
  assert_at(fb_rig, user, 96);
  assert_at(fb_rig, evaluate, 104);
  assert_at(fb_rig, destroy, 112);
  assert_at(fb_rig, uv_count, 120);
  assert_at(fb_rig, uvs, 128);
  assert_at(fb_rig, uv_corners, 136);

  assert_int_equal(sizeof(fb_source), 16);
  assert_int_equal(sizeof(fb_sample_desc), 72);
  assert_at(fb_sample_desc, source, 8);
  assert_at(fb_sample_desc, directory, 24);
  assert_at(fb_sample_desc, poses, 32);
  assert_at(fb_sample_desc, seed, 40);
  assert_at(fb_sample_desc, mix, 48);
  assert_at(fb_sample_desc, progress, 56);
  assert_at(fb_sample_desc, progress_user, 64);

  assert_int_equal(sizeof(fb_bake_desc), 80);
  assert_at(fb_bake_desc, sources, 8);
  assert_at(fb_bake_desc, source_count, 16);
  assert_at(fb_bake_desc, archive, 24);
  assert_at(fb_bake_desc, recipe, 32);
  assert_at(fb_bake_desc, use, 40);
  assert_at(fb_bake_desc, poses, 48);
  assert_at(fb_bake_desc, seed, 56);
  assert_at(fb_bake_desc, progress, 64);
  assert_at(fb_bake_desc, progress_user, 72);
}

static void init_functions_set_sizes_and_defaults(void** state) {
  (void)state;
  fb_load_desc load;
  fb_load_desc_init(&load);
  assert_int_equal(load.struct_size, sizeof load);
  assert_true(load.max_file_bytes == (uint64_t)4 << 30);
  assert_true(load.max_model_bytes == (uint64_t)4 << 30);
  assert_true(load.allocator.allocate == NULL && load.log == NULL);
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
      cmocka_unit_test(layout_of_runtime_structs),
      cmocka_unit_test(layout_of_bake_structs),
      cmocka_unit_test(init_functions_set_sizes_and_defaults),
      cmocka_unit_test(structs_of_other_headers_are_filled_to_their_size),
      cmocka_unit_test(statuses_have_names),
      cmocka_unit_test(version_as_string_and_number_agree),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
