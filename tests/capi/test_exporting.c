/* Faces in other forms through the C interface: an ONNX model, joints with skin weights. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { poses = 24 };

static fb_archive* archive;
static fb_model* model;
static float* positions; /* poses x 3 x vertices, the first at rest */
static size_t floats;    /* of a pose */

static void assert_refused(fb_status status, fb_status expected, const char* message_part) {
  assert_int_equal(status, expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("%s has no %s", fb_last_error(), message_part);
}

static int open_face(void** state) {
  (void)state;
  assert_ok(fb_archive_open(FB_CHARACTER, &archive));
  assert_ok(fb_load(FB_CHARACTER, NULL, &model));
  floats = 3 * (size_t)fb_vertex_count(model);
  positions = malloc(poses * floats * sizeof(float));
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 1, &scratch));
  const uint32_t controls = fb_control_count(model);
  float* pose = malloc(controls * sizeof(float));
  for (uint32_t p = 0; p < poses; ++p) {
    for (uint32_t c = 0; c < controls; ++c) {
      fb_control control;
      fb_control_init(&control);
      assert_ok(fb_control_at(model, c, &control));
      const float share = (float)((p * (c + 3) * 7) % 10) / 9;
      pose[c] = p == 0 ? control.rest : control.minimum + share * (control.maximum - control.minimum);
    }
    assert_ok(fb_evaluate(model, scratch, pose, positions + p * floats));
  }
  free(pose);
  fb_scratch_destroy(scratch);
  return 0;
}

static int close_face(void** state) {
  (void)state;
  free(positions);
  fb_release(model);
  fb_archive_close(archive);
  return 0;
}

static void an_onnx_model_is_written_whole_or_not_at_all(void** state) {
  (void)state;
  char path[] = "/tmp/facebaker-onnx-XXXXXX", none[64];
  close(mkstemp(path));
  fb_report* report = NULL;
  assert_ok(fb_export_onnx(archive, path, &report));
  assert_non_null(strstr(fb_report_json(report), "\"parameters\""));
  fb_report_free(report);
  FILE* file = fopen(path, "rb");
  char head[16];
  assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
  assert_memory_equal(head,
                      "\x08\x07\x12\x09"
                      "FaceBaker",
                      13); /* version 7 of the form, and who wrote it */
  fclose(file);
  assert_ok(fb_export_onnx(archive, path, NULL));
  unlink(path);
  snprintf(none, sizeof none, "%s/face.onnx", path);
  assert_refused(fb_export_onnx(archive, none, NULL), FB_ERROR_IO, "face.onnx");
  assert_refused(fb_export_onnx(NULL, path, NULL), FB_ERROR_INVALID_ARGUMENT, "archive");
  assert_refused(fb_export_onnx(archive, NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "path");
}

/* The sum of squared distances of all poses from where joints take the vertices. */
static double squares_off(const fb_decomposition_info* info, const float* frames) {
  double squares = 0;
  const float* rest = fb_rest_positions(model);
  for (size_t p = 0; p < poses; ++p)
    for (size_t v = 0; v < info->vertex_count; ++v)
      for (size_t axis = 0; axis < 3; ++axis) {
        double at = 0;
        for (size_t k = 0; k < info->influences; ++k) {
          const size_t place = info->influences * v + k, joint = info->joints[place];
          const float* row = frames + 12 * (p * info->joint_count + joint) + 4 * axis;
          double to = row[3];
          for (size_t i = 0; i < 3; ++i) to += (double)row[i] * (rest[3 * v + i] - info->centres[3 * joint + i]);
          at += info->weights[place] * to;
        }
        const double off = at - positions[p * floats + 3 * v + axis];
        squares += off * off;
      }
  return squares;
}

static double squares_moved(void) {
  double squares = 0;
  for (size_t i = 0; i < poses * floats; ++i) {
    const double moved = positions[i] - positions[i % floats];
    squares += moved * moved;
  }
  return squares;
}

static void joints_move_a_face_the_better_the_more_there_are(void** state) {
  (void)state;
  double before = squares_moved();
  for (uint32_t joints = 1; joints <= 16; joints *= 4) {
    fb_decompose_desc desc;
    fb_decompose_desc_init(&desc);
    assert_int_equal(desc.joints, 32);
    desc.archive = archive;
    desc.positions = positions;
    desc.poses = poses;
    desc.joints = joints;
    fb_decomposition* decomposition = NULL;
    assert_ok(fb_decompose(&desc, &decomposition));
    fb_decomposition_info info;
    fb_decomposition_info_init(&info);
    assert_ok(fb_decomposition_describe(decomposition, &info));
    assert_true(info.joint_count >= 1 && info.joint_count <= joints);
    assert_true(info.influences == 4 && info.vertex_count == fb_vertex_count(model));
    for (size_t v = 0; v < info.vertex_count; ++v) {
      double sum = 0;
      for (size_t k = 0; k < 4; ++k) {
        const float weight = info.weights[4 * v + k];
        assert_true(weight >= 0 && info.joints[4 * v + k] < info.joint_count);
        assert_true(k == 0 || weight <= info.weights[4 * v + k - 1]);
        sum += weight;
      }
      assert_true(fabs(sum - 1) < 1e-5);
    }
    float* frames = malloc(poses * info.joint_count * 12 * sizeof(float));
    assert_ok(fb_decomposition_fit(decomposition, positions, poses, 1, frames));
    for (size_t i = 0; i < poses * info.joint_count; ++i) /* rotations */
      for (size_t row = 0; row < 3; ++row)
        assert_true(
            fabs(hypot(hypot(frames[12 * i + 4 * row], frames[12 * i + 4 * row + 1]), frames[12 * i + 4 * row + 2]) -
                 1) < 1e-4);
    const double off = squares_off(&info, frames);
    assert_true(off < before);
    before = off;
    free(frames);
    fb_decomposition_free(decomposition);
  }
}

static void wrong_uses_are_refused(void** state) {
  (void)state;
  fb_decomposition* decomposition = NULL;
  fb_decompose_desc desc;
  fb_decompose_desc_init(&desc);
  desc.positions = positions;
  desc.poses = 2;
  assert_refused(fb_decompose(&desc, &decomposition), FB_ERROR_INVALID_ARGUMENT, "archive");
  desc.archive = archive;
  desc.joints = 0;
  assert_refused(fb_decompose(&desc, &decomposition), FB_ERROR_INVALID_ARGUMENT, "joints");
  desc.joints = 2, desc.poses = 0;
  assert_refused(fb_decompose(&desc, &decomposition), FB_ERROR_INVALID_ARGUMENT, "poses");
  desc.poses = 2, desc.positions = NULL;
  assert_refused(fb_decompose(&desc, &decomposition), FB_ERROR_INVALID_ARGUMENT, "positions");
  desc.positions = positions;
  const float kept = positions[floats + 4];
  positions[floats + 4] = NAN;
  assert_refused(fb_decompose(&desc, &decomposition), FB_ERROR_NOT_FINITE, "pose 1, vertex 1");
  positions[floats + 4] = kept;
  assert_null(decomposition);
  assert_refused(fb_decomposition_describe(NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "decomposition");
  fb_decomposition_free(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_onnx_model_is_written_whole_or_not_at_all),
      cmocka_unit_test(joints_move_a_face_the_better_the_more_there_are),
      cmocka_unit_test(wrong_uses_are_refused),
  };
  return cmocka_run_group_tests(tests, open_face, close_face);
}
