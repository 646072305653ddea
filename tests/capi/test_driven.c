/* Joints that the controls drive: what they are, where they are in a pose, and that a host which skins by itself gets
 * what the library gives. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <math.h>
#include <string.h>

enum { CONTROLS = 5, VERTICES = 30, POSES = 9, FLOATS = 3 * VERTICES, JOINTS = 4, FRAMES = JOINTS * FB_FRAME_FLOATS };

static fb_model *face, *tiny;
static fb_scratch* scratch;
static float controls[POSES * CONTROLS]; /* the first at rest */
static float positions[POSES * FLOATS], frames[POSES * FRAMES];

static int load(void** state) {
  (void)state;
  if (fb_load(FB_DRIVEN, NULL, &face) != FB_OK || fb_load(FB_FIXTURE, NULL, &tiny) != FB_OK) return -1;
  if (fb_scratch_create(face, 2, &scratch) != FB_OK) return -1;
  for (int i = 0; i < POSES * CONTROLS; ++i)
    controls[i] = i < CONTROLS ? fb_rest_controls(face)[i] : (float)(i * 37 % 101) / 101;
  return 0;
}

static int release(void** state) {
  (void)state;
  fb_scratch_destroy(scratch);
  fb_release(face);
  fb_release(tiny);
  return 0;
}

static fb_batch_desc describe(void) {
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * CONTROLS;
  desc.positions = positions;
  desc.position_floats = POSES * FLOATS;
  return desc;
}

static void joints_are_those_of_the_archive(void** state) {
  (void)state;
  fb_driven_joint joint;
  fb_driven_joint_init(&joint);
  assert_true(joint.parent == FB_NO_JOINT && joint.numbers == 0 && joint.rest[0] == 1 && joint.rest[5] == 1);
  assert_int_equal(fb_driven_joint_count(face), JOINTS);
  uint32_t index = 7;
  assert_ok(fb_find_driven_joint(face, "tongue", &index));
  assert_int_equal(index, 1);
  assert_ok(fb_driven_joint_at(face, 1, &joint));
  assert_string_equal(joint.name, "tongue");
  assert_int_equal(joint.parent, 0);
  assert_int_equal(joint.numbers, FB_JOINT_ROTATE_X | FB_JOINT_ROTATE_Y | FB_JOINT_MOVE_Z);
  assert_int_equal(joint.outer_rotations, 0);
  assert_true(joint.rest[1] == -1 && joint.rest[3] == 0.5f);
  assert_ok(fb_driven_joint_at(face, 3, &joint));
  assert_int_equal(joint.numbers, FB_JOINT_ROTATE | FB_JOINT_MOVE | FB_JOINT_SCALE | FB_JOINT_PIVOT);
  assert_int_equal(joint.outer_rotations, 2);
  assert_int_equal(fb_driven_joint_at(face, JOINTS, &joint), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_find_driven_joint(face, "hand", &index), FB_ERROR_NOT_FOUND);
  assert_string_equal(fb_last_error(),
                      "there is no driven joint \"hand\"; there are \"jaw\", \"tongue\", \"pin\", \"lid\"");
  /* They are not the skeleton of a host. */
  assert_int_equal(fb_joint_count(face), 0);
  assert_int_equal(fb_skin_influences(face), 0);
  assert_int_equal(fb_driven_joint_count(tiny), 0);
  assert_int_equal(fb_driven_influences(tiny), 0);
  assert_null(fb_driven_skin_joints(tiny));
  assert_null(fb_driven_skin_weights(NULL));
}

/* Takes a vertex along by a joint: adds weight * (frame * (inverse of rest) * p - p). Frames at rest are orthonormal.
 */
static void follow(const float* rest, const float* frame, float weight, const float* p, double* moved) {
  double local[3] = {0, 0, 0};
  for (int a = 0; a < 3; ++a)
    for (int row = 0; row < 3; ++row) local[a] += rest[4 * row + a] * ((double)p[row] - rest[4 * row + 3]);
  for (int a = 0; a < 3; ++a) {
    const float* row = frame + 4 * a;
    moved[a] += weight * (row[0] * local[0] + row[1] * local[1] + row[2] * local[2] + row[3] - p[a]);
  }
}

static void a_host_that_skins_gets_the_same(void** state) {
  (void)state;
  static float before[POSES * FLOATS], displaced[POSES * FLOATS];
  fb_batch_desc desc = describe();
  desc.joints = frames;
  desc.joint_floats = POSES * FRAMES;
  assert_ok(fb_evaluate_batch(face, scratch, &desc));
  desc = describe();
  desc.positions = before;
  desc.unskinned = 1;
  assert_ok(fb_evaluate_batch(face, scratch, &desc));
  desc.positions = displaced;
  desc.unskinned = 0;
  desc.displacements = 1;
  assert_ok(fb_evaluate_batch(face, scratch, &desc));
  const uint32_t influences = fb_driven_influences(face);
  assert_int_equal(influences, 3);
  const uint16_t* joints = fb_driven_skin_joints(face);
  const float *weights = fb_driven_skin_weights(face), *rest = fb_rest_positions(face);
  double furthest = 0;
  for (int p = 0; p < POSES; ++p)
    for (uint32_t v = 0; v < VERTICES; ++v) {
      const float* from = before + p * FLOATS + 3 * v;
      double moved[3] = {from[0], from[1], from[2]};
      for (uint32_t i = v * influences; i < (v + 1) * influences; ++i) {
        fb_driven_joint joint;
        fb_driven_joint_init(&joint);
        assert_ok(fb_driven_joint_at(face, joints[i], &joint));
        follow(joint.rest, frames + p * FRAMES + FB_FRAME_FLOATS * joints[i], weights[i], from, moved);
      }
      for (int a = 0; a < 3; ++a) {
        const float seen = positions[p * FLOATS + 3 * v + a];
        assert_true(fabs(moved[a] - seen) < 1e-5 * (1 + fabs(moved[a])) * 4);
        furthest = fmax(furthest, fabs((double)seen - from[a]));
        assert_true(displaced[p * FLOATS + 3 * v + a] == from[a] - rest[3 * v + a]);
        if (p == 0) assert_true(seen == rest[3 * v + a]);
      }
    }
  assert_true(furthest > 1);
  for (int j = 0; j < JOINTS; ++j) {
    fb_driven_joint joint;
    fb_driven_joint_init(&joint);
    assert_ok(fb_driven_joint_at(face, j, &joint));
    assert_memory_equal(frames + FB_FRAME_FLOATS * j, joint.rest, sizeof joint.rest);
  }
}

static void what_is_wrong_is_refused(void** state) {
  (void)state;
  fb_batch_desc desc = describe();
  desc.unskinned = 2;
  assert_int_equal(fb_evaluate_batch(face, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "fb_batch_desc: unskinned 2, neither 0 nor 1");
  desc = describe();
  desc.positions = NULL; /* joints alone are an output */
  desc.joints = frames;
  desc.joint_floats = POSES * FRAMES - 1;
  assert_int_equal(fb_evaluate_batch(face, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "9 poses need 432 floats of driven joints; the buffer has 431");
  desc.joint_floats = POSES * FRAMES;
  assert_ok(fb_evaluate_batch(face, scratch, &desc));
  fb_scratch* other = NULL;
  assert_ok(fb_scratch_create(tiny, 1, &other));
  desc.control_stride = CONTROLS;
  assert_int_equal(fb_evaluate_batch(tiny, other, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "the face has no driven joints");
  fb_scratch_destroy(other);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(joints_are_those_of_the_archive),
      cmocka_unit_test(a_host_that_skins_gets_the_same),
      cmocka_unit_test(what_is_wrong_is_refused),
  };
  return cmocka_run_group_tests(tests, load, release);
}
