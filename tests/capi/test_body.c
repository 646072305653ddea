/* What puts a face on a body: joints and skin, displacements, and bounds of poses. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <math.h>
#include <string.h>

enum { CONTROLS = 5, VERTICES = 30, HEAD = 18, POSES = 9, FLOATS = 3 * VERTICES, BOUNDS = 6 };

static fb_model *body, *tiny;
static fb_scratch* scratch;
static float controls[POSES * CONTROLS]; /* the first at rest */
static float positions[POSES * FLOATS];  /* one by one, in the source's order */

static int load(void** state) {
  (void)state;
  if (fb_load(FB_BODY, NULL, &body) != FB_OK || fb_load(FB_FIXTURE, NULL, &tiny) != FB_OK) return -1;
  if (fb_scratch_create(body, 2, &scratch) != FB_OK) return -1;
  for (int i = 0; i < POSES * CONTROLS; ++i)
    controls[i] = i < CONTROLS ? fb_rest_controls(body)[i] : (float)(i * 37 % 101) / 101;
  for (int p = 0; p < POSES; ++p)
    if (fb_evaluate(body, scratch, controls + p * CONTROLS, positions + p * FLOATS) != FB_OK) return -1;
  return 0;
}

static int release(void** state) {
  (void)state;
  fb_scratch_destroy(scratch);
  fb_release(body);
  fb_release(tiny);
  return 0;
}

static fb_batch_desc describe(void) {
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * CONTROLS;
  return desc;
}

static void joints_are_those_of_the_source(void** state) {
  (void)state;
  fb_joint joint;
  fb_joint_init(&joint);
  assert_int_equal(joint.parent, FB_NO_JOINT);
  assert_true(joint.rest[0] == 1 && joint.rest[5] == 1 && joint.rest[10] == 1 && joint.inverse_bind[0] == 0);
  assert_int_equal(fb_joint_count(body), 3);
  uint32_t index = 7;
  assert_ok(fb_find_joint(body, "head", &index));
  assert_int_equal(index, 1);
  assert_ok(fb_joint_at(body, 1, &joint));
  assert_string_equal(joint.name, "head");
  assert_int_equal(joint.parent, 0);
  assert_true(joint.rest[0] == 2 && joint.rest[7] == 1 && joint.inverse_bind[3] == -0.5f);
  assert_ok(fb_joint_at(body, 0, &joint));
  assert_int_equal(joint.parent, FB_NO_JOINT);
  assert_int_equal(fb_joint_at(body, 3, &joint), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_find_joint(body, "hand", &index), FB_ERROR_NOT_FOUND);
  assert_string_equal(fb_last_error(), "there is no joint \"hand\"; there are \"neck\", \"head\", \"jaw\"");
  memset(&joint, 0x5a, sizeof joint);
  joint.struct_size = offsetof(fb_joint, rest);
  assert_ok(fb_joint_at(body, 2, &joint));
  assert_string_equal(joint.name, "jaw");
  unsigned char kept[sizeof joint.rest];
  memset(kept, 0x5a, sizeof kept);
  assert_memory_equal(joint.rest, kept, sizeof kept);
  assert_int_equal(fb_joint_count(tiny), 0);
  assert_int_equal(fb_joint_count(NULL), 0);
}

static void the_skin_is_that_of_the_source(void** state) {
  (void)state;
  assert_int_equal(fb_skin_influences(body), 2);
  const uint16_t* joints = fb_skin_joints(body);
  const float* weights = fb_skin_weights(body);
  assert_true(joints[0] == 1 && weights[0] == 1 && weights[1] == 0);
  assert_true(joints[2 * 7] == 1 && joints[2 * 7 + 1] == 2 && weights[2 * 7] == 0.5f && weights[2 * 7 + 1] == 0.5f);
  for (int v = 0; v < VERTICES; ++v) assert_true(weights[2 * v] + weights[2 * v + 1] == (v < HEAD ? 1 : 0));
  assert_int_equal(fb_skin_influences(tiny), 0);
  assert_null(fb_skin_joints(tiny));
  assert_null(fb_skin_weights(tiny));
  assert_int_equal(fb_skin_influences(NULL), 0);
  assert_null(fb_skin_joints(NULL));
}

static void displacements_are_positions_less_rest_positions(void** state) {
  (void)state;
  static float found[POSES * FLOATS], normals[POSES * FLOATS], expected_normals[POSES * FLOATS];
  static uint16_t halves[POSES * VERTICES * 4];
  fb_batch_desc desc = describe();
  desc.normals = expected_normals;
  desc.normal_numbers = POSES * FLOATS;
  assert_ok(fb_evaluate_batch(body, scratch, &desc));
  desc.positions = found;
  desc.position_floats = POSES * FLOATS;
  desc.displacements = 1;
  const float* rest = fb_rest_positions(body);
  const uint32_t* order = fb_vertex_order(body);
  for (int with_normals = 0; with_normals < 2; ++with_normals)
    for (uint32_t vertex_order = FB_ORDER_SOURCE; vertex_order <= FB_ORDER_BAKED; ++vertex_order) {
      desc.vertex_order = vertex_order;
      desc.normals = with_normals && vertex_order == FB_ORDER_SOURCE ? normals : NULL;
      assert_ok(fb_evaluate_batch(body, scratch, &desc));
      int moved = 0;
      for (int p = 0; p < POSES; ++p)
        for (int v = 0; v < VERTICES; ++v)
          for (int axis = 0; axis < 3; ++axis) {
            const uint32_t at = 3 * (vertex_order == FB_ORDER_BAKED ? order[v] : (uint32_t)v) + (uint32_t)axis;
            const float displacement = found[p * FLOATS + 3 * v + axis];
            assert_true(displacement == positions[p * FLOATS + at] - rest[at]);
            if (p == 0) assert_true(displacement == 0 && !signbit(displacement));
            moved += displacement != 0;
          }
      assert_true(moved > POSES * FLOATS / 2);
    }
  assert_memory_equal(normals, expected_normals, sizeof normals);
  /* One mesh, in halves, with gaps between vertices, which are kept. */
  const uint32_t teeth = 1;
  desc = describe();
  desc.positions = halves;
  desc.position_floats = POSES * VERTICES * 4;
  desc.vertex_stride = 4;
  desc.format = FB_FLOAT16;
  desc.displacements = 1;
  desc.meshes = &teeth;
  desc.mesh_count = 1;
  for (int i = 0; i < POSES * VERTICES * 4; ++i) halves[i] = 77;
  assert_ok(fb_evaluate_batch(body, scratch, &desc));
  for (int i = 0; i < POSES * VERTICES * 4; ++i) {
    const int vertex = i / 4 % VERTICES, at = 3 * vertex + i % 4;
    if (vertex < HEAD || i % 4 == 3) {
      assert_int_equal(halves[i], 77);
      continue;
    }
    const float exact = positions[i / 4 / VERTICES * FLOATS + at] - rest[at];
    const int exponent = (halves[i] >> 10 & 31) - 25;
    const float size = ldexpf((float)(exponent > -25 ? 1024 + (halves[i] & 1023) : 2 * (halves[i] & 1023)), exponent);
    assert_true(fabsf((halves[i] & 0x8000 ? -size : size) - exact) <= fabsf(exact) / 2048 + 1e-7f);
  }
  desc.displacements = 2;
  assert_int_equal(fb_evaluate_batch(body, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "fb_batch_desc: displacements 2, neither 0 nor 1");
}

/* Those of vertices first to end - 1 of a pose. */
static void find_bounds(int pose, int first, int end, float* bounds) {
  for (int axis = 0; axis < 3; ++axis) {
    const float* at = positions + pose * FLOATS + axis;
    bounds[axis] = bounds[3 + axis] = at[3 * first];
    for (int v = first; v < end; ++v) {
      if (at[3 * v] < bounds[axis]) bounds[axis] = at[3 * v];
      if (at[3 * v] > bounds[3 + axis]) bounds[3 + axis] = at[3 * v];
    }
  }
}

static void bounds_are_those_of_the_posed_meshes(void** state) {
  (void)state;
  enum { STRIDE = BOUNDS + 2 };
  static float found[POSES * STRIDE], written[POSES * FLOATS];
  const uint32_t head = 0, teeth = 1;
  const struct {
    const uint32_t* meshes;
    uint64_t count;
    int first, end;
  } cases[] = {{NULL, 0, 0, VERTICES}, {&head, 1, 0, HEAD}, {&teeth, 1, HEAD, VERTICES}, {&head, 0, 0, 0}};
  for (int c = 0; c < 4; ++c)
    for (int with = 0; with < 4; ++with) { /* bounds alone; with positions, displacements, halves */
      fb_batch_desc desc = describe();
      desc.meshes = cases[c].meshes;
      desc.mesh_count = cases[c].count;
      desc.bounds = found;
      desc.bounds_floats = POSES * STRIDE;
      desc.bounds_pose_stride = STRIDE;
      desc.positions = with > 0 ? written : NULL;
      desc.position_floats = with > 0 ? POSES * FLOATS : 0;
      desc.displacements = with == 2;
      desc.format = with == 3 ? FB_FLOAT16 : FB_FLOAT32;
      desc.vertex_order = with == 1 ? FB_ORDER_BAKED : FB_ORDER_SOURCE;
      desc.threads = with % 2 ? 1 : 2;
      for (int i = 0; i < POSES * STRIDE; ++i) found[i] = 77;
      assert_ok(fb_evaluate_batch(body, scratch, &desc));
      for (int p = 0; p < POSES; ++p) {
        float expected[BOUNDS] = {0};
        if (cases[c].end > 0) find_bounds(p, cases[c].first, cases[c].end, expected);
        assert_memory_equal(found + p * STRIDE, expected, sizeof expected);
        assert_true(found[p * STRIDE + BOUNDS] == 77 && found[p * STRIDE + BOUNDS + 1] == 77);
      }
    }
  fb_batch_desc desc = describe();
  desc.bounds = found;
  desc.bounds_floats = POSES * BOUNDS - 1;
  assert_int_equal(fb_evaluate_batch(body, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "9 poses need 54 floats of bounds; the buffer has 53");
  desc.bounds_floats = POSES * STRIDE;
  desc.bounds_pose_stride = BOUNDS - 1;
  assert_int_equal(fb_evaluate_batch(body, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
}

static void an_older_host_gets_positions(void** state) {
  (void)state;
  static float found[POSES * FLOATS];
  fb_batch_desc desc = describe();
  desc.struct_size = offsetof(fb_batch_desc, displacements);
  desc.displacements = 1;
  desc.positions = found;
  desc.position_floats = POSES * FLOATS;
  assert_ok(fb_evaluate_batch(body, scratch, &desc));
  assert_memory_equal(found, positions, sizeof found);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(joints_are_those_of_the_source),
      cmocka_unit_test(the_skin_is_that_of_the_source),
      cmocka_unit_test(displacements_are_positions_less_rest_positions),
      cmocka_unit_test(bounds_are_those_of_the_posed_meshes),
      cmocka_unit_test(an_older_host_gets_positions),
  };
  return cmocka_run_group_tests(tests, load, release);
}
