/* What the native library solves, for the tests of the npm package.
 *   native_solves ARCHIVE SOLVES OUT   random poses, derivatives at them, and the controls found for their points, see
 *                                      expected_solves.ts */
#include <facebaker/facebaker.h>
#include <facebaker/facebaker_character.h>
#include <facebaker/facebaker_solve.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "native_helpers.h"

enum { MOST_POINTS = 24 };

/* A third of the controls somewhere in their ranges, the others at rest. */
static void draw_pose(const fb_model* model, float* pose) {
  for (uint32_t c = 0; c < fb_control_count(model); ++c) {
    fb_control control;
    fb_control_init(&control);
    check(fb_control_at(model, c, &control));
    const float moved = draw(), value = draw();
    pose[c] = moved > 0.33f ? control.rest : control.minimum + value * (control.maximum - control.minimum);
  }
}

/* Some vertices, spread; the frames of all sockets and driven joints. */
static fb_solver* make_solver(const fb_model* model, uint32_t points, const uint32_t* corners) {
  uint32_t* const all = allocate(sizeof(uint32_t) * (fb_socket_count(model) + fb_driven_joint_count(model) + 1));
  for (uint32_t i = 0; i < fb_socket_count(model) + fb_driven_joint_count(model); ++i) all[i] = i;
  fb_solver_desc desc;
  fb_solver_desc_init(&desc);
  desc.point_count = points;
  desc.point_vertices = corners;
  desc.sockets = desc.joints = all;
  desc.socket_count = fb_socket_count(model);
  desc.joint_count = fb_driven_joint_count(model);
  fb_solver* solver = NULL;
  check(fb_solver_create(model, &desc, &solver));
  free(all);
  return solver;
}

/* Odd solves want symmetry, stay near the pose before and leave every third control alone. */
static void solve(fb_solver* solver, uint32_t index, uint32_t controls, const float* targets, float* found,
                  float* decided, float* differences, fb_solve_result* result) {
  fb_solve_desc desc;
  fb_solve_desc_init(&desc);
  uint8_t* const movable = allocate(controls);
  for (uint32_t c = 0; c < controls; ++c) movable[c] = c % 3 != 0;
  float* const before = allocate(sizeof(float) * controls);
  memcpy(before, found, sizeof(float) * controls);
  desc.points = targets;
  desc.controls = found;
  desc.decided = decided;
  desc.point_differences = differences;
  if (index % 2 == 1) {
    desc.symmetry = 0.5f;
    desc.sparsity = 0;
    desc.smoothness = 0.25f;
    desc.near_controls = desc.before = before;
    desc.movable = movable;
  }
  check(fb_solve(solver, &desc, result));
  free(movable);
  free(before);
}

int main(int count, char** arguments) {
  if (count != 4) return 2;
  fb_model* model = NULL;
  check(fb_load(arguments[1], NULL, &model));
  const uint32_t solves = (uint32_t)atoi(arguments[2]), controls = fb_control_count(model), vertices = fb_vertex_count(model),
                 points = vertices < MOST_POINTS ? vertices : MOST_POINTS;
  uint32_t corners[3 * MOST_POINTS];
  for (uint32_t i = 0; i < points; ++i) corners[3 * i] = corners[3 * i + 1] = corners[3 * i + 2] = i * (vertices / points);
  fb_solver* const solver = make_solver(model, points, corners);
  const uint32_t rows = fb_solver_row_count(solver),
                 header[] = {solves, controls, points, rows, fb_socket_count(model), fb_driven_joint_count(model)};
  float* const pose = allocate(sizeof(float) * controls);
  float* const found = allocate(sizeof(float) * controls);
  float* const decided = allocate(sizeof(float) * controls);
  float* const values = allocate(sizeof(float) * rows);
  float* const derivatives = allocate(sizeof(float) * rows * controls);
  float differences[MOST_POINTS];
  memcpy(found, fb_rest_controls(model), sizeof(float) * controls);
  FILE* const file = fopen(arguments[3], "wb");
  if (!file) exit(3);
  fwrite(header, sizeof header, 1, file);
  fwrite(corners, sizeof(uint32_t), 3 * points, file);
  for (uint32_t s = 0; s < solves; ++s) {
    draw_pose(model, pose);
    fb_jacobian_desc desc;
    fb_jacobian_desc_init(&desc);
    desc.controls = pose;
    desc.values = values;
    desc.derivatives = derivatives;
    desc.derivative_floats = (uint64_t)rows * controls;
    check(fb_jacobian(solver, &desc));
    fb_solve_result result;
    fb_solve_result_init(&result);
    solve(solver, s, controls, values, found, decided, differences, &result);
    const uint32_t whole[] = {result.iterations, result.converged, result.point_count, result.worst_point};
    const float far[] = {result.rms_difference, result.max_difference};
    fwrite(pose, sizeof(float), controls, file);
    fwrite(values, sizeof(float), rows, file);
    fwrite(derivatives, sizeof(float), (size_t)rows * controls, file);
    fwrite(found, sizeof(float), controls, file);
    fwrite(decided, sizeof(float), controls, file);
    fwrite(differences, sizeof(float), points, file);
    fwrite(whole, sizeof whole, 1, file);
    fwrite(far, sizeof far, 1, file);
    fwrite(&result.objective, sizeof(double), 1, file);
  }
  return fclose(file) == 0 ? 0 : 3;
}
