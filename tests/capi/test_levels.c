/* Levels of detail as a host sees them. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VERTICES = 30, FLOATS = 3 * VERTICES, CONTROLS = 5 };

static fb_model *levels, *tiny;
static fb_scratch* scratch;
static const float pose[CONTROLS] = {0.5f, 0.75f, 0.25f, 0.5f, 0.25f};

static int load(void** state) {
  (void)state;
  return fb_load(FB_LEVELS, NULL, &levels) != FB_OK || fb_load(FB_FIXTURE, NULL, &tiny) != FB_OK ||
         fb_scratch_create(levels, 2, &scratch) != FB_OK;
}

static int release(void** state) {
  (void)state;
  fb_scratch_destroy(scratch);
  fb_release(levels);
  fb_release(tiny);
  return 0;
}

static fb_level level_of(const fb_model* model, uint32_t index) {
  fb_level level;
  fb_level_init(&level);
  assert_ok(fb_level_at(model, index, &level));
  return level;
}

static fb_batch_desc batch_to(float* positions, float lod) {
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = pose;
  batch.control_floats = CONTROLS;
  batch.positions = positions;
  batch.position_floats = FLOATS;
  batch.lod = lod;
  return batch;
}

static void the_layout_of_levels_is_pinned(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_level), 56);
  assert_int_equal(offsetof(fb_level, vertex_count), 4);
  assert_int_equal(offsetof(fb_level, polygon_count), 8);
  assert_int_equal(offsetof(fb_level, corner_count), 12);
  assert_int_equal(offsetof(fb_level, polygon_sizes), 16);
  assert_int_equal(offsetof(fb_level, polygon_corners), 24);
  assert_int_equal(offsetof(fb_level, uv_corners), 32);
  assert_int_equal(offsetof(fb_level, meshes), 40);
  assert_int_equal(offsetof(fb_level, coefficient_count), 48);
}

static void levels_have_polygons_of_their_own(void** state) {
  (void)state;
  assert_int_equal(fb_level_count(levels), 3);
  const fb_level whole = level_of(levels, 0), first = level_of(levels, 1), second = level_of(levels, 2);
  assert_int_equal(whole.vertex_count, fb_vertex_count(levels));
  assert_int_equal(whole.polygon_count, fb_polygon_count(levels));
  assert_int_equal(whole.corner_count, fb_polygon_corner_count(levels));
  assert_ptr_equal(whole.polygon_corners, fb_polygon_corners(levels));
  assert_ptr_equal(whole.uv_corners, fb_uv_corners(levels));
  assert_int_equal(whole.coefficient_count, fb_coefficient_count(levels));
  assert_int_equal(first.vertex_count, 19);
  assert_int_equal(first.polygon_count, 5);
  assert_int_equal(first.corner_count, 19);
  assert_int_equal(second.vertex_count, 13);
  assert_true(second.coefficient_count <= first.coefficient_count);
  const uint32_t* order = fb_vertex_order(levels);
  for (uint32_t c = 0; c < first.corner_count; ++c) {
    uint32_t i = 0;
    while (i < first.vertex_count && order[i] != first.polygon_corners[c]) ++i;
    assert_true(i < first.vertex_count);
    assert_true(first.uv_corners[c] < fb_uv_count(levels));
  }
  assert_string_equal(first.meshes[1].name, "teeth");
  assert_int_equal(first.meshes[1].first_vertex, 18);
  assert_int_equal(first.meshes[1].vertex_count, 12);
  assert_int_equal(first.meshes[1].first_polygon, 3);
  assert_int_equal(first.meshes[1].polygon_count, 2);
  assert_int_equal(first.meshes[1].first_corner, 11);
  assert_int_equal(first.meshes[1].corner_count, 8);
  assert_int_equal(first.meshes[0].run_count, 2);
  assert_int_equal(first.meshes[0].runs[0].polygon_count, 2);
  assert_int_equal(first.meshes[0].runs[1].material, FB_NO_MATERIAL);
}

static void a_face_without_levels_has_itself(void** state) {
  (void)state;
  assert_int_equal(fb_level_count(tiny), 1);
  const fb_level whole = level_of(tiny, 0);
  assert_int_equal(whole.vertex_count, fb_vertex_count(tiny));
  assert_int_equal(whole.polygon_count, fb_polygon_count(tiny));
  fb_level level;
  fb_level_init(&level);
  assert_int_equal(fb_level_at(tiny, 1, &level), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_level_at(NULL, 0, &level), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_level_count(NULL), 0);
}

static void level_0_is_what_a_pose_is_without_levels(void** state) {
  (void)state;
  float whole[FLOATS], positions[FLOATS];
  assert_ok(fb_evaluate(levels, scratch, pose, whole));
  const fb_batch_desc batch = batch_to(positions, 0);
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  assert_memory_equal(positions, whole, sizeof whole);
}

static void positions_are_continuous_in_the_level(void** state) {
  (void)state;
  float before[FLOATS], positions[FLOATS];
  fb_batch_desc batch = batch_to(before, 0);
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  for (int step = 1; step <= 2048; ++step) {
    batch = batch_to(positions, (float)step / 1024);
    assert_ok(fb_evaluate_batch(levels, scratch, &batch));
    for (int i = 0; i < FLOATS; ++i) assert_true(fabsf(positions[i] - before[i]) < 0.05f);
    memcpy(before, positions, sizeof before);
  }
  batch = batch_to(positions, 100);
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  assert_memory_equal(positions, before, sizeof before);
}

static void a_level_alone_is_written_in_baked_order(void** state) {
  (void)state;
  float all[FLOATS], positions[FLOATS];
  fb_batch_desc batch = batch_to(all, 1.5f);
  batch.vertex_order = FB_ORDER_BAKED;
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  batch = batch_to(positions, 1.5f);
  batch.level_only = 1;
  assert_int_equal(fb_evaluate_batch(levels, scratch, &batch), FB_ERROR_INVALID_ARGUMENT);
  batch.vertex_order = FB_ORDER_BAKED;
  batch.position_floats = 3 * 19;
  for (int i = 0; i < FLOATS; ++i) positions[i] = 77;
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  assert_memory_equal(positions, all, 3 * 19 * sizeof(float));
  for (int i = 3 * 19; i < FLOATS; ++i) assert_true(positions[i] == 77);
  batch.level_only = 2;
  assert_int_equal(fb_evaluate_batch(levels, scratch, &batch), FB_ERROR_INVALID_ARGUMENT);
}

static void levels_that_are_no_numbers_are_refused(void** state) {
  (void)state;
  float positions[FLOATS];
  fb_batch_desc batch = batch_to(positions, NAN);
  assert_int_equal(fb_evaluate_batch(levels, scratch, &batch), FB_ERROR_NOT_FINITE);
  batch = batch_to(positions, -1);
  assert_int_equal(fb_evaluate_batch(levels, scratch, &batch), FB_ERROR_INVALID_ARGUMENT);
  /* A host that does not know of levels gets the whole. */
  float whole[FLOATS];
  assert_ok(fb_evaluate(levels, scratch, pose, whole));
  batch.struct_size = offsetof(fb_batch_desc, lod);
  assert_ok(fb_evaluate_batch(levels, scratch, &batch));
  assert_memory_equal(positions, whole, sizeof whole);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_layout_of_levels_is_pinned),
      cmocka_unit_test(levels_have_polygons_of_their_own),
      cmocka_unit_test(a_face_without_levels_has_itself),
      cmocka_unit_test(level_0_is_what_a_pose_is_without_levels),
      cmocka_unit_test(positions_are_continuous_in_the_level),
      cmocka_unit_test(a_level_alone_is_written_in_baked_order),
      cmocka_unit_test(levels_that_are_no_numbers_are_refused),
  };
  return cmocka_run_group_tests(tests, load, release);
}
