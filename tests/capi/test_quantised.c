/* Poses that a host computes by itself, from quantised coefficients and digits of the basis: the sums are whole
 * numbers, so that it gets fb_evaluate's bits before driven joints. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POSES = 27 }; /* blocks of poses, and single ones */

/* A face with poses of it, and what a host needs to pose it. */
typedef struct posed_face {
  fb_model* model;
  fb_scratch* scratch;
  uint32_t vertices, controls, columns, blocks, exact, joints;
  float *poses, *expected, *steps, *weights, *frames;
  int16_t* quantised;
} posed_face;

static void* room(size_t count, size_t size) {
  void* const memory = calloc(count > 0 ? count : 1, size);
  assert_non_null(memory);
  return memory;
}

/* Poses at rest, the exact ones, and others of all controls or few of them, some beyond their ranges. */
static void draw_poses(posed_face* face) {
  uint32_t random = 1;
  for (uint32_t p = 0; p < POSES; ++p)
    for (uint32_t c = 0; c < face->controls; ++c) {
      fb_control control;
      fb_control_init(&control);
      assert_ok(fb_control_at(face->model, c, &control));
      random = random * 1664525u + 1013904223u;
      const float value = (float)(random >> 8) / (1 << 24) * (p % 8 == 7 ? 1.5f : 1.0f);
      const int rests = p == 0 || (p % 3 == 1 && random % 5 > 0);
      face->poses[p * face->controls + c] =
          rests ? control.rest : control.minimum + value * (control.maximum - control.minimum);
    }
  fb_exact_pose exact;
  fb_exact_pose_init(&exact);
  for (uint32_t e = 0; e < face->exact; ++e) {
    assert_ok(fb_exact_pose_at(face->model, e, &exact));
    float* const pose = face->poses + (size_t)(POSES - 1 - e) * face->controls;
    memcpy(pose, exact.controls, face->controls * sizeof(float));
    pose[0] += e % 2 ? 0.03125f : 0; /* near it */
  }
}

static posed_face open_face(const char* path) {
  posed_face face;
  memset(&face, 0, sizeof face);
  assert_ok(fb_load(path, NULL, &face.model));
  assert_ok(fb_scratch_create(face.model, 1, &face.scratch));
  face.vertices = fb_vertex_count(face.model);
  face.controls = fb_control_count(face.model);
  face.columns = fb_digit_column_count(face.model);
  face.blocks = fb_row_block_count(face.model);
  face.exact = fb_exact_pose_count(face.model);
  face.joints = fb_driven_joint_count(face.model);
  face.poses = room((size_t)POSES * face.controls, sizeof(float));
  face.expected = room((size_t)POSES * 3 * face.vertices, sizeof(float));
  face.quantised = room((size_t)POSES * face.columns, sizeof(int16_t));
  face.steps = room((size_t)POSES * face.blocks, sizeof(float));
  face.weights = room((size_t)POSES * face.exact, sizeof(float));
  face.frames = room((size_t)POSES * 12 * face.joints, sizeof(float));
  draw_poses(&face);
  return face;
}

static void close_face(posed_face* face) {
  fb_scratch_destroy(face->scratch);
  fb_release(face->model);
  free(face->poses);
  free(face->expected);
  free(face->quantised);
  free(face->steps);
  free(face->weights);
  free(face->frames);
}

static fb_quantised_desc describe(const posed_face* face) {
  fb_quantised_desc desc;
  fb_quantised_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = face->poses;
  desc.control_floats = (uint64_t)POSES * face->controls;
  desc.quantised = face->quantised;
  desc.quantised_numbers = (uint64_t)POSES * face->columns;
  desc.steps = face->steps;
  desc.step_floats = (uint64_t)POSES * face->blocks;
  if (face->exact > 0) desc.exact_weights = face->weights;
  desc.exact_weight_floats = (uint64_t)POSES * face->exact;
  if (face->joints > 0) desc.joints = face->frames;
  desc.joint_floats = (uint64_t)POSES * 12 * face->joints;
  return desc;
}

/* What the library gives before driven joints move vertices. */
static void evaluate(posed_face* face, int displacements, float* frames) {
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = face->poses;
  desc.control_floats = (uint64_t)POSES * face->controls;
  desc.positions = face->expected;
  desc.position_floats = (uint64_t)POSES * 3 * face->vertices;
  desc.unskinned = 1;
  desc.displacements = displacements != 0;
  if (face->joints > 0) desc.joints = frames;
  desc.joint_floats = (uint64_t)POSES * 12 * face->joints;
  assert_ok(fb_evaluate_batch(face->model, face->scratch, &desc));
}

/* Rounds after each operation, whatever the compiler would fuse. */
static float multiply(float a, float b) {
  volatile float product = a * b;
  return product;
}

/* The positions of a row block in a pose, as facebaker.h says. `changed`: a digit to be one too large, or -1. */
static void pose_rows(const posed_face* face, uint32_t pose, uint32_t index, uint32_t first_column, int64_t changed,
                      float* positions) {
  fb_row_block block;
  fb_row_block_init(&block);
  assert_ok(fb_row_block_at(face->model, index, &block));
  const uint32_t rows = block.row_count, columns = block.digit_column_count;
  uint32_t* const used = room(columns, sizeof(uint32_t));
  float *const scales = room(columns, sizeof(float)), *const corrections = room(rows, sizeof(float));
  int8_t* const digits = room((size_t)columns * rows, 1);
  assert_ok(fb_row_block_digits(face->model, index, used, scales, digits));
  if (changed >= 0) ++digits[changed];
  const uint32_t* const order = fb_vertex_order(face->model);
  const float step = face->steps[pose * face->blocks + index];
  const int16_t* const quantised = face->quantised + (size_t)pose * face->columns + first_column;
  for (uint32_t r = 0; r < rows; ++r) {
    const uint32_t row = block.first_row + r, at = 3 * (order ? order[row / 3] : row / 3) + row % 3;
    int32_t sum = 0;
    for (uint32_t c = 0; c < columns; ++c) sum += quantised[c] * digits[(size_t)c * rows + r];
    const float rest = fb_rest_positions(face->model)[at];
    positions[at] = step == 0 ? rest : rest + multiply(step, (float)sum);
  }
  for (uint32_t e = 0; e < face->exact; ++e) {
    const float weight = face->weights[pose * face->exact + e];
    uint32_t corrects = 7;
    assert_ok(fb_exact_corrections(face->model, e, index, corrections, &corrects));
    for (uint32_t r = 0; r < rows && corrects && weight != 0; ++r) {
      const uint32_t row = block.first_row + r, at = 3 * (order ? order[row / 3] : row / 3) + row % 3;
      positions[at] = positions[at] + multiply(weight, corrections[r]);
    }
  }
  free(used);
  free(scales);
  free(digits);
  free(corrections);
}

/* Poses in which a host gets other bits. `changed`: of the digits of the first row block, or -1. */
static int count_differences(const posed_face* face, int displacements, int64_t changed) {
  const size_t size = 3 * (size_t)face->vertices;
  float* const positions = room(size, sizeof(float));
  const float* const rest = fb_rest_positions(face->model);
  int different = 0;
  for (uint32_t p = 0; p < POSES; ++p) {
    fb_row_block block;
    fb_row_block_init(&block);
    for (uint32_t b = 0, column = 0; b < face->blocks; ++b, column += block.digit_column_count) {
      pose_rows(face, p, b, column, b == 0 ? changed : -1, positions);
      assert_ok(fb_row_block_at(face->model, b, &block));
    }
    for (size_t i = 0; i < size && displacements; ++i) positions[i] -= rest[i];
    different += memcmp(positions, face->expected + p * size, size * sizeof(float)) != 0;
  }
  free(positions);
  return different;
}

static const char* const archives[] = {FB_FIXTURE,
                                       FB_CHARACTER,
                                       FB_BODY,
                                       FB_DRIVEN,
                                       FB_EXACT,
                                       FB_LEVELS,
                                       FB_GOLDEN "/2.0/accepted/rows-1.fbk",
                                       FB_GOLDEN "/2.0/accepted/rows-5.fbk",
                                       FB_GOLDEN "/2.0/accepted/digit-bases.fbk",
                                       FB_GOLDEN "/2.0/accepted/arithmetic.fbk",
                                       FB_GOLDEN "/2.0/accepted/overflow.fbk",
                                       FB_GOLDEN "/2.1/accepted/driven-exact-levels.fbk",
                                       FB_GOLDEN "/2.1/accepted/driven-split-rows.fbk"};

static void a_host_gets_the_same_bits(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof archives / sizeof *archives; ++i) {
    posed_face face = open_face(archives[i]);
    const fb_quantised_desc desc = describe(&face);
    float* const frames = room((size_t)POSES * 12 * face.joints, sizeof(float));
    assert_ok(fb_evaluate_quantised(face.model, face.scratch, &desc));
    const uint64_t clamped = fb_clamped_count(face.scratch);
    for (int displacements = 0; displacements < 2; ++displacements) {
      evaluate(&face, displacements, frames);
      if (count_differences(&face, displacements, -1) > 0) fail_msg("%s: other bits", archives[i]);
    }
    assert_int_equal(fb_clamped_count(face.scratch), clamped);
    assert_memory_equal(face.frames, frames, (size_t)POSES * 12 * face.joints * sizeof(float));
    free(frames);
    close_face(&face);
  }
}

static void a_changed_digit_shows(void** state) {
  (void)state;
  float frames[1] = {0};
  posed_face face = open_face(FB_FIXTURE);
  const fb_quantised_desc desc = describe(&face);
  assert_ok(fb_evaluate_quantised(face.model, face.scratch, &desc));
  evaluate(&face, 0, frames);
  assert_true(count_differences(&face, 0, 0) > 0);
  close_face(&face);
}

/* Alone, in a batch of other strides, and by a scratch for single poses. */
static void batches_and_strides_do_not_matter(void** state) {
  (void)state;
  posed_face face = open_face(FB_EXACT);
  fb_quantised_desc desc = describe(&face);
  assert_ok(fb_evaluate_quantised(face.model, face.scratch, &desc));
  const uint64_t columns = face.columns + 3, blocks = face.blocks + 1, exact = face.exact + 2;
  int16_t* const quantised = room(POSES * columns, sizeof(int16_t));
  float *const steps = room(POSES * blocks, sizeof(float)), *const weights = room(POSES * exact, sizeof(float));
  fb_scratch* single = NULL;
  assert_ok(fb_scratch_create_single(face.model, 1, &single));
  desc.quantised = quantised;
  desc.quantised_numbers = POSES * (desc.quantised_pose_stride = columns);
  desc.steps = steps;
  desc.step_floats = POSES * (desc.step_pose_stride = blocks);
  desc.exact_weights = weights;
  desc.exact_weight_floats = POSES * (desc.exact_weight_pose_stride = exact);
  assert_ok(fb_evaluate_quantised(face.model, single, &desc));
  for (size_t p = 0; p < POSES; ++p) {
    assert_memory_equal(quantised + p * columns, face.quantised + p * face.columns, face.columns * sizeof(int16_t));
    assert_memory_equal(steps + p * blocks, face.steps + p * face.blocks, face.blocks * sizeof(float));
    assert_memory_equal(weights + p * exact, face.weights + p * face.exact, face.exact * sizeof(float));
    assert_true(quantised[p * columns + face.columns] == 0 && steps[p * blocks + face.blocks] == 0);
  }
  fb_scratch_destroy(single);
  free(quantised);
  free(steps);
  free(weights);
  close_face(&face);
}

static void wrong_requests_are_refused_before_anything_is_written(void** state) {
  (void)state;
  posed_face face = open_face(FB_FIXTURE);
  memset(face.quantised, 1, (size_t)POSES * face.columns * sizeof(int16_t));
  fb_quantised_desc bad[10];
  for (int i = 0; i < 10; ++i) bad[i] = describe(&face);
  bad[0].quantised_numbers -= 1;
  bad[1].quantised_pose_stride = face.columns - 1;
  bad[2].step_floats -= 1;
  bad[3].step_pose_stride = face.blocks - 1;
  bad[4].exact_weights = face.steps;
  bad[5].joints = face.steps;
  bad[6].control_floats -= 1;
  bad[7].controls = NULL;
  bad[8].poses = UINT64_MAX;
  bad[9].struct_size = 0;
  for (int i = 0; i < 10; ++i) {
    const fb_status status = fb_evaluate_quantised(face.model, face.scratch, &bad[i]);
    assert_true(status == FB_ERROR_INVALID_ARGUMENT || status == FB_ERROR_LIMIT);
    assert_int_equal(face.quantised[0], 0x101);
  }
  const fb_quantised_desc good = describe(&face);
  assert_int_equal(fb_evaluate_quantised(NULL, face.scratch, &good), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate_quantised(face.model, NULL, &good), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate_quantised(face.model, face.scratch, NULL), FB_ERROR_INVALID_ARGUMENT);
  face.poses[2 * face.controls + 1] = NAN;
  assert_int_equal(fb_evaluate_quantised(face.model, face.scratch, &good), FB_ERROR_NOT_FINITE);
  assert_non_null(strstr(fb_last_error(), "pose 2"));
  assert_int_equal(face.quantised[0], 0x101);
  assert_int_equal(fb_exact_corrections(face.model, 0, 0, NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "exact pose 0 of 0");
  assert_int_equal(fb_exact_corrections(NULL, 0, 0, NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_digit_column_count(NULL), 0);
  close_face(&face);
  face = open_face(FB_EXACT);
  assert_int_equal(fb_exact_corrections(face.model, 0, face.blocks, NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_ok(fb_exact_corrections(face.model, 0, 0, NULL, NULL));
  close_face(&face);
}

static void nothing_has_to_be_asked_for(void** state) {
  (void)state;
  posed_face face = open_face(FB_DRIVEN);
  fb_quantised_desc desc;
  fb_quantised_desc_init(&desc);
  assert_ok(fb_evaluate_quantised(face.model, face.scratch, &desc));
  desc = describe(&face);
  desc.quantised = NULL;
  desc.steps = desc.joints = NULL;
  desc.quantised_numbers = 0;
  assert_ok(fb_evaluate_quantised(face.model, face.scratch, &desc));
  close_face(&face);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_host_gets_the_same_bits),
      cmocka_unit_test(a_changed_digit_shows),
      cmocka_unit_test(batches_and_strides_do_not_matter),
      cmocka_unit_test(wrong_requests_are_refused_before_anything_is_written),
      cmocka_unit_test(nothing_has_to_be_asked_for),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
