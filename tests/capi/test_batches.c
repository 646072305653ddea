#define POSES 17
#define WORKERS 4
#include "batch_fixture.h"

#include <math.h>
#include <string.h>

/* A host's scheduler, backwards and with all its workers. */
static void backwards(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  ++*(int*)user;
  for (uint32_t i = count; i-- > 0;) task(context, i, i % workers);
}

static void batches_equal_single_poses(void** state) {
  (void)state;
  for (uint32_t threads = 0; threads <= WORKERS; ++threads) {
    float positions[POSES * FLOATS] = {0};
    fb_batch_desc desc = describe(positions, POSES * FLOATS);
    desc.threads = threads;
    assert_ok(fb_evaluate_batch(model, scratch, &desc));
    assert_memory_equal(positions, expected, sizeof positions);
  }
}

static void a_scratch_for_single_poses_gives_the_same_batches(void** state) {
  (void)state;
  float positions[POSES * FLOATS] = {0}, one[FLOATS];
  fb_scratch* single = NULL;
  assert_int_equal(fb_scratch_create_single(model, 0, &single), FB_ERROR_INVALID_ARGUMENT);
  assert_ok(fb_scratch_create_single(model, 2, &single));
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  assert_ok(fb_evaluate_batch(model, single, &desc));
  assert_memory_equal(positions, expected, sizeof positions);
  assert_ok(fb_evaluate(model, single, controls, one));
  assert_memory_equal(one, expected, sizeof one);
  fb_scratch_destroy(single);
}

static void a_host_may_schedule(void** state) {
  (void)state;
  float positions[POSES * FLOATS] = {0};
  int calls = 0;
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.parallel_for = backwards;
  desc.parallel_user = &calls;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_int_equal(calls, 1);
  assert_memory_equal(positions, expected, sizeof positions);
}

static void strides_are_honoured(void** state) {
  (void)state;
  enum { vertex_stride = 5, pose_stride = VERTICES * vertex_stride + 7, size = POSES * pose_stride };
  static float positions[size];
  for (int i = 0; i < size; ++i) positions[i] = 77;
  fb_batch_desc desc = describe(positions, size);
  desc.vertex_stride = vertex_stride;
  desc.pose_stride = pose_stride;
  desc.control_stride = CONTROLS - 1; /* sliding windows are allowed: controls are only read */
  desc.poses = POSES;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  for (int p = 0; p < POSES; ++p) {
    float single[FLOATS];
    assert_ok(fb_evaluate(model, scratch, controls + p * (CONTROLS - 1), single));
    for (int i = 0; i < pose_stride; ++i) {
      const int vertex = i / vertex_stride, axis = i % vertex_stride;
      const float value = vertex < VERTICES && axis < 3 ? single[vertex * 3 + axis] : 77;
      assert_true(positions[p * pose_stride + i] == value);
    }
  }
}

static void clamping_is_counted_over_the_batch(void** state) {
  (void)state;
  float positions[POSES * FLOATS];
  uint64_t outside = 0;
  for (int p = 0; p < POSES; ++p) {
    assert_ok(fb_evaluate(model, scratch, controls + p * CONTROLS, positions));
    outside += fb_clamped_count(scratch);
  }
  assert_true(outside > 0);
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_int_equal(fb_clamped_count(scratch), outside);
}

static void wrong_batches_are_refused_before_anything_is_written(void** state) {
  (void)state;
  float positions[POSES * FLOATS], before[POSES * FLOATS];
  for (int i = 0; i < POSES * FLOATS; ++i) positions[i] = before[i] = 7;
  const fb_batch_desc good = describe(positions, POSES * FLOATS);
  fb_batch_desc bad[11];
  for (int i = 0; i < 11; ++i) bad[i] = good;
  bad[0].control_floats -= 1;
  bad[1].position_floats -= 1;
  bad[2].vertex_stride = 2;
  bad[3].pose_stride = FLOATS - 1;
  bad[4].controls = NULL;
  bad[5].positions = NULL;
  bad[6].poses = UINT64_MAX;
  bad[7].control_stride = UINT64_MAX;
  bad[8].pose_stride = UINT64_MAX / 2;
  bad[9].threads = WORKERS + 1;
  bad[10].struct_size = 0;
  for (int i = 0; i < 11; ++i) {
    const fb_status status = fb_evaluate_batch(model, scratch, &bad[i]);
    assert_true(status == FB_ERROR_INVALID_ARGUMENT || status == FB_ERROR_LIMIT);
    assert_memory_equal(positions, before, sizeof positions);
  }
  assert_int_equal(fb_evaluate_batch(NULL, scratch, &good), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate_batch(model, NULL, &good), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate_batch(model, scratch, NULL), FB_ERROR_INVALID_ARGUMENT);

  const float saved = controls[11 * CONTROLS + 1];
  controls[11 * CONTROLS + 1] = NAN;
  assert_int_equal(fb_evaluate_batch(model, scratch, &good), FB_ERROR_NOT_FINITE);
  assert_non_null(strstr(fb_last_error(), "pose 11"));
  assert_non_null(strstr(fb_last_error(), "\"mouth_side\""));
  assert_memory_equal(positions, before, sizeof positions);
  controls[11 * CONTROLS + 1] = saved;
}

/* A host's scheduler that uses the batch's scratch meanwhile. */
static void intrude(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  (void)workers;
  float positions[FLOATS];
  fb_status* seen = user;
  seen[0] = fb_evaluate(model, scratch, controls, positions);
  seen[1] = strstr(fb_last_error(), "in use") == NULL;
  for (uint32_t i = 0; i < count; ++i) task(context, i, 0);
}

static void a_scratch_serves_one_call_at_a_time(void** state) {
  (void)state;
  static float positions[POSES * FLOATS];
  fb_status seen[2] = {FB_OK, 1};
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.parallel_for = intrude;
  desc.parallel_user = seen;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_int_equal(seen[0], FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(seen[1], 0);
  assert_memory_equal(positions, expected, sizeof positions);
  desc.poses = UINT64_MAX; /* a call that fails gives the scratch back, too */
  assert_int_not_equal(fb_evaluate_batch(model, scratch, &desc), FB_OK);
  assert_ok(fb_evaluate(model, scratch, controls, positions));
}

static void an_empty_batch_does_nothing(void** state) {
  (void)state;
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(batches_equal_single_poses),
      cmocka_unit_test(a_scratch_for_single_poses_gives_the_same_batches),
      cmocka_unit_test(a_host_may_schedule),
      cmocka_unit_test(strides_are_honoured),
      cmocka_unit_test(clamping_is_counted_over_the_batch),
      cmocka_unit_test(wrong_batches_are_refused_before_anything_is_written),
      cmocka_unit_test(a_scratch_serves_one_call_at_a_time),
      cmocka_unit_test(an_empty_batch_does_nothing),
  };
  return cmocka_run_group_tests(tests, open_model, close_model);
}
