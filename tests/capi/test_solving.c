/* Derivatives and solving as a host calls them: outputs, errors that name what is wrong, and hostile targets. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <facebaker/facebaker_solve.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CONTROLS = 16, MOST_FLOATS = 4096 };

static fb_model *face, *driven; /* the other one with driven joints that turn far */
static uint32_t controls, vertices;
static fb_solver* solver; /* of all vertices */

static int load(void** state) {
  (void)state;
  if (fb_load(FB_CHARACTER, NULL, &face) != FB_OK || fb_load(FB_DRIVEN, NULL, &driven) != FB_OK) return 1;
  controls = fb_control_count(face);
  vertices = fb_vertex_count(face);
  return controls > MOST_CONTROLS || 3 * vertices > MOST_FLOATS || fb_solver_create(face, NULL, &solver) != FB_OK;
}

static int release(void** state) {
  (void)state;
  fb_solver_destroy(solver);
  fb_release(face);
  fb_release(driven);
  return 0;
}

static fb_control control_of(uint32_t index) {
  fb_control control;
  fb_control_init(&control);
  assert_ok(fb_control_at(face, index, &control));
  return control;
}

/* A pose that is `share` of the way from rest to the ends of ranges. */
static void pose_at(float share, float* pose) {
  for (uint32_t c = 0; c < controls; ++c) {
    const fb_control control = control_of(c);
    const float end = c % 2 ? control.minimum : control.maximum;
    pose[c] = control.rest + share * (end - control.rest);
  }
}

static void positions_of(const float* pose, float* positions) {
  fb_scratch* scratch;
  assert_ok(fb_scratch_create_single(face, 1, &scratch));
  assert_ok(fb_evaluate(face, scratch, pose, positions));
  fb_scratch_destroy(scratch);
}

static fb_jacobian_desc jacobian_of(const float* pose, float* values) {
  fb_jacobian_desc desc;
  fb_jacobian_desc_init(&desc);
  desc.controls = pose;
  desc.values = values;
  return desc;
}

static void values_are_those_of_the_pose(void** state) {
  (void)state;
  float pose[MOST_CONTROLS], values[MOST_FLOATS], positions[MOST_FLOATS];
  pose_at(0.4f, pose);
  positions_of(pose, positions);
  assert_int_equal(fb_solver_point_count(solver), vertices);
  assert_int_equal(fb_solver_row_count(solver), 3 * vertices);
  const fb_jacobian_desc desc = jacobian_of(pose, values);
  assert_ok(fb_jacobian(solver, &desc));
  for (uint32_t i = 0; i < 3 * vertices; ++i) assert_true(fabsf(values[i] - positions[i]) < 1e-5f);
}

static void derivatives_are_differences_of_poses(void** state) {
  (void)state;
  const uint32_t rows = 3 * vertices;
  float pose[MOST_CONTROLS], moved[MOST_CONTROLS], before[MOST_FLOATS], after[MOST_FLOATS];
  float* derivatives = malloc(sizeof(float) * rows * controls);
  pose_at(0.4f, pose);
  positions_of(pose, before);
  fb_jacobian_desc desc = jacobian_of(pose, NULL);
  desc.derivatives = derivatives;
  desc.derivative_floats = (uint64_t)rows * controls;
  assert_ok(fb_jacobian(solver, &desc));
  for (uint32_t c = 0; c < controls; ++c) {
    const float step = 2e-3f * (control_of(c).maximum - control_of(c).minimum);
    memcpy(moved, pose, sizeof moved);
    moved[c] += step;
    positions_of(moved, after);
    for (uint32_t row = 0; row < rows; ++row)
      assert_true(fabsf((after[row] - before[row]) / step - derivatives[row * controls + c]) <
                  0.02f * fb_diagonal(face));
  }
  free(derivatives);
}

static void sparse_columns_hold_what_dense_ones_do(void** state) {
  (void)state;
  fb_solver_desc of;
  fb_solver_desc_init(&of);
  const uint32_t points[6] = {3, 7, 11, 20, 20, 0}, pair[2] = {0, 1};
  const float weights[6] = {0.5f, 0.25f, 0.25f, 1, 0, 0};
  const uint32_t sockets = fb_socket_count(driven), joints = fb_driven_joint_count(driven);
  uint32_t all[64];
  for (uint32_t i = 0; i < 64; ++i) all[i] = i;
  of.point_count = 2;
  of.point_vertices = points;
  of.point_weights = weights;
  of.pairs = pair;
  of.pair_count = 1;
  of.sockets = of.joints = all;
  of.socket_count = sockets;
  of.joint_count = joints;
  fb_solver* some;
  assert_ok(fb_solver_create(driven, &of, &some));
  const uint32_t rows = fb_solver_row_count(some), chosen[3] = {0, 2, 3};
  assert_int_equal(rows, 6 + 12 * (sockets + joints));
  float pose[MOST_CONTROLS], dense[MOST_FLOATS] = {0}, values[MOST_FLOATS];
  uint32_t entry_rows[MOST_FLOATS];
  uint64_t starts[4];
  memcpy(pose, fb_rest_controls(driven), fb_control_count(driven) * sizeof *pose);
  pose[0] = 0.25f;
  fb_jacobian_desc desc = jacobian_of(pose, NULL);
  desc.chosen = chosen;
  desc.chosen_count = 3;
  desc.derivatives = dense;
  desc.derivative_floats = 3 * rows;
  desc.column_starts = starts;
  assert_ok(fb_jacobian(some, &desc)); /* counts them */
  const uint64_t entries = starts[3];
  assert_true(entries > 3 && entries <= 3 * rows);
  desc.column_rows = entry_rows;
  desc.column_values = values;
  desc.column_entries = entries - 1;
  assert_int_equal(fb_jacobian(some, &desc), FB_ERROR_LIMIT);
  assert_non_null(strstr(fb_last_error(), "column_entries"));
  desc.column_entries = entries;
  assert_ok(fb_jacobian(some, &desc));
  float* expected = calloc(3 * rows, sizeof *expected);
  for (uint32_t c = 0; c < 3; ++c)
    for (uint64_t e = starts[c]; e < starts[c + 1]; ++e) {
      assert_true(e == starts[c] || entry_rows[e] > entry_rows[e - 1]);
      assert_true(values[e] != 0);
      expected[entry_rows[e] * 3 + c] = values[e];
    }
  assert_memory_equal(expected, dense, 3 * rows * sizeof *expected);
  free(expected);
  fb_solver_destroy(some);
}

static void a_pose_is_found_again(void** state) {
  (void)state;
  float pose[MOST_CONTROLS], found[MOST_CONTROLS], targets[MOST_FLOATS], at[MOST_FLOATS], differences[MOST_FLOATS],
      decided[MOST_CONTROLS];
  pose_at(0.3f, pose);
  positions_of(pose, targets);
  targets[7] = NAN; /* not measured */
  fb_solve_desc desc;
  fb_solve_desc_init(&desc);
  fb_solve_result result;
  fb_solve_result_init(&result);
  pose_at(0.25f, found); /* the frame before */
  desc.points = targets;
  desc.controls = found;
  desc.noise = (float)(1e-4 * fb_diagonal(face));
  desc.nearness = desc.sparsity = 0;
  desc.max_iterations = 50;
  desc.decided = decided;
  desc.point_differences = differences;
  assert_ok(fb_solve(solver, &desc, &result));
  assert_true(result.converged && result.iterations > 0 && result.point_count == vertices - 1);
  assert_true(result.max_difference < 5e-3 * fb_diagonal(face) && result.rms_difference <= result.max_difference);
  assert_true(isnan(differences[2]) && differences[result.worst_point] == result.max_difference);
  positions_of(found, at);
  for (uint32_t i = 0; i < 3 * vertices; ++i)
    if (i != 7) assert_true(fabsf(at[i] - targets[i]) < 1e-2 * fb_diagonal(face));
  for (uint32_t c = 0; c < controls; ++c) assert_true(decided[c] >= 0 && decided[c] <= 1);
}

static void targets_come_from_spaces_and_units_of_their_own(void** state) {
  (void)state;
  float pose[MOST_CONTROLS], found[MOST_CONTROLS], targets[MOST_FLOATS];
  pose_at(0.25f, pose);
  positions_of(pose, targets);
  const float* rest = fb_rest_positions(face);
  for (uint32_t i = 0; i < 3 * vertices; ++i) targets[i] -= rest[i];
  fb_solve_desc desc;
  fb_solve_desc_init(&desc);
  fb_solve_result result;
  fb_solve_result_init(&result);
  desc.points = targets;
  desc.controls = found;
  desc.noise = (float)(1e-4 * fb_diagonal(face));
  desc.relative = 1;
  memcpy(found, pose, sizeof found);
  assert_ok(fb_solve(solver, &desc, &result));
  assert_true(result.max_difference < 5e-3 * fb_diagonal(face));
  /* In tenths of the unit, z up, moved: to the face by 0.1 (x, z, -y) - (1, 2, 3). */
  const float to_face[12] = {0.1f, 0, 0, -1, 0, 0, 0.1f, -2, 0, -0.1f, 0, -3};
  for (uint32_t v = 0; v < vertices; ++v) {
    float* const p = targets + 3 * v;
    const float x = p[0] + rest[3 * v] + 1, y = p[1] + rest[3 * v + 1] + 2, z = p[2] + rest[3 * v + 2] + 3;
    p[0] = 10 * x, p[1] = -10 * z, p[2] = 10 * y;
  }
  desc.relative = 0;
  memcpy(desc.to_face, to_face, sizeof to_face);
  memcpy(found, pose, sizeof found);
  assert_ok(fb_solve(solver, &desc, &result));
  assert_true(result.max_difference < 5e-3 * fb_diagonal(face));
  /* And where the head is, is found. */
  float motion[12] = {0};
  const float shift[12] = {1, 0, 0, 0.5f, 0, 1, 0, -0.25f, 0, 0, 1, 1};
  for (uint32_t v = 0; v < vertices; ++v) targets[3 * v] += 5, targets[3 * v + 1] -= 10, targets[3 * v + 2] -= 2.5f;
  desc.find_motion = 1;
  desc.motion = motion;
  memcpy(found, pose, sizeof found);
  assert_ok(fb_solve(solver, &desc, &result));
  for (uint32_t i = 0; i < 12; ++i) assert_true(fabsf(motion[i] - shift[i]) < 0.02f);
}

static void refuse_solver(fb_solver_desc* desc, const char* what) {
  fb_solver* made = NULL;
  assert_int_equal(fb_solver_create(face, desc, &made), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), what));
  assert_null(made);
  fb_solver_desc_init(desc);
}

static void what_there_is_not_cannot_be_followed(void** state) {
  (void)state;
  fb_solver_desc desc;
  fb_solver_desc_init(&desc);
  const uint32_t far_vertex[3] = {0, 0, vertices}, wrong = 1000;
  const float weights[3] = {1, 0, 1}, broken[3] = {1, NAN, 0};
  desc.point_count = 1;
  desc.point_vertices = far_vertex;
  desc.point_weights = weights;
  refuse_solver(&desc, "point 0 has vertex");
  desc.point_count = 1;
  desc.point_vertices = far_vertex;
  desc.point_weights = broken;
  refuse_solver(&desc, "weight 1 of point 0");
  desc.pairs = far_vertex;
  desc.pair_count = 1;
  fb_solver* made = NULL;
  assert_ok(fb_solver_create(face, &desc, &made)); /* points 0 and 0 */
  fb_solver_destroy(made);
  desc.pairs = far_vertex + 1;
  refuse_solver(&desc, "pair 0 has point");
  desc.sockets = &wrong;
  desc.socket_count = 1;
  refuse_solver(&desc, "socket 1000");
  desc.joints = &wrong;
  desc.joint_count = 1;
  refuse_solver(&desc, "driven joint 1000");
  desc.lod = NAN;
  refuse_solver(&desc, "lod");
}

static fb_solve_desc solve_to(const float* targets, float* found) {
  fb_solve_desc desc;
  fb_solve_desc_init(&desc);
  desc.points = targets;
  desc.controls = found;
  return desc;
}

static void refuse(const fb_solve_desc* desc, fb_status status, const char* what) {
  float before[MOST_CONTROLS];
  memcpy(before, desc->controls, controls * sizeof *before);
  assert_int_equal(fb_solve(solver, desc, NULL), status);
  assert_non_null(strstr(fb_last_error(), what));
  assert_memory_equal(before, desc->controls, controls * sizeof *before);
}

static void what_cannot_be_solved_is_named(void** state) {
  (void)state;
  float targets[MOST_FLOATS], found[MOST_CONTROLS], weights[MOST_FLOATS], motion[12];
  memcpy(targets, fb_rest_positions(face), 3 * vertices * sizeof *targets);
  memcpy(found, fb_rest_controls(face), controls * sizeof *found);
  for (uint32_t v = 0; v < vertices; ++v) weights[v] = 1;
  targets[4] = INFINITY;
  fb_solve_desc desc = solve_to(targets, found);
  refuse(&desc, FB_ERROR_NOT_FINITE, "point 1");
  targets[4] = 1e30f;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "point 1");
  targets[4] = 0;
  weights[5] = -1;
  desc.point_weights = weights;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "point_weights[5]");
  desc = solve_to(targets, found);
  desc.sparsity = NAN;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "sparsity");
  desc = solve_to(targets, found);
  desc.to_face[5] = 2;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "to_face");
  desc = solve_to(targets, found);
  desc.find_motion = 1;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "motion");
  for (uint32_t i = 0; i < 12; ++i) motion[i] = 1;
  desc.motion = motion;
  refuse(&desc, FB_ERROR_INVALID_ARGUMENT, "motion");
  desc = solve_to(targets, found);
  found[2] = NAN;
  assert_int_equal(fb_solve(solver, &desc, NULL), FB_ERROR_NOT_FINITE);
  assert_non_null(strstr(fb_last_error(), control_of(2).name));
}

/* A float of any bits, more often one of some size. */
static float any_float(uint64_t* seed) {
  *seed = *seed * 6364136223846793005u + 1442695040888963407u;
  const uint32_t bits = (uint32_t)(*seed >> 32);
  float number;
  memcpy(&number, &bits, sizeof number);
  return bits % 4 == 0 ? number : ((float)(bits % 2001) - 1000) * (bits % 3 == 0 ? 1e-3f : 1.0f);
}

static void hostile_targets_end_in_a_status_or_in_ranges(void** state) {
  (void)state;
  float targets[MOST_FLOATS], found[MOST_CONTROLS], weights[MOST_FLOATS], motion[12] = {0};
  uint64_t seed = 1;
  int solved = 0;
  for (int i = 0; i < 10000; ++i) {
    for (uint32_t k = 0; k < 3 * vertices; ++k) targets[k] = i % 3 ? any_float(&seed) : fb_rest_positions(face)[k];
    for (uint32_t v = 0; v < vertices; ++v) weights[v] = i % 2 ? 1 : fabsf(any_float(&seed));
    memcpy(found, fb_rest_controls(face), controls * sizeof *found);
    fb_solve_desc desc = solve_to(targets, found);
    desc.point_weights = weights;
    desc.noise = i % 5 ? 0 : fabsf(any_float(&seed));
    desc.sparsity = i % 7 ? 0.1f : any_float(&seed);
    desc.find_motion = i % 4 == 0;
    desc.motion = motion;
    desc.max_iterations = 3;
    fb_solve_result result;
    fb_solve_result_init(&result);
    const fb_status status = fb_solve(solver, &desc, &result);
    assert_true(status == FB_OK || status == FB_ERROR_NOT_FINITE || status == FB_ERROR_INVALID_ARGUMENT);
    for (uint32_t c = 0; c < controls; ++c)
      assert_true(found[c] >= control_of(c).minimum && found[c] <= control_of(c).maximum);
    if (status != FB_OK) continue;
    ++solved;
    assert_true(isfinite(result.rms_difference) && isfinite(result.max_difference));
    for (int k = 0; k < 12; ++k) assert_true(isfinite(motion[k]));
    if (i % 16 == 0) memset(motion, 0, sizeof motion);
  }
  assert_true(solved > 1000);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_are_those_of_the_pose),
      cmocka_unit_test(derivatives_are_differences_of_poses),
      cmocka_unit_test(sparse_columns_hold_what_dense_ones_do),
      cmocka_unit_test(a_pose_is_found_again),
      cmocka_unit_test(targets_come_from_spaces_and_units_of_their_own),
      cmocka_unit_test(what_there_is_not_cannot_be_followed),
      cmocka_unit_test(what_cannot_be_solved_is_named),
      cmocka_unit_test(hostile_targets_end_in_a_status_or_in_ranges),
  };
  return cmocka_run_group_tests(tests, load, release);
}
