#include "capi_test.h"

#include <fenv.h>
#include <math.h>
#include <string.h>

#define CONTROLS 5
#define FLOATS 90

static fb_model* model;
static fb_scratch* scratch;

static int open_model(void** state) {
  (void)state;
  model = load_tiny();
  return fb_scratch_create(model, 1, &scratch);
}

static int close_model(void** state) {
  (void)state;
  fb_scratch_destroy(scratch);
  fb_release(model);
  return 0;
}

static void rest_controls_give_the_rest_mesh(void** state) {
  (void)state;
  float positions[FLOATS];
  assert_ok(fb_evaluate(model, scratch, fb_rest_controls(model), positions));
  assert_memory_equal(positions, fb_rest_positions(model), sizeof positions);
  assert_int_equal(fb_clamped_count(scratch), 0);
}

static void a_control_moves_vertices(void** state) {
  (void)state;
  float controls[CONTROLS], positions[FLOATS], again[FLOATS];
  memcpy(controls, fb_rest_controls(model), sizeof controls);
  controls[0] = 1;
  assert_ok(fb_evaluate(model, scratch, controls, positions));
  assert_memory_not_equal(positions, fb_rest_positions(model), sizeof positions);
  for (int i = 0; i < FLOATS; ++i) assert_true(isfinite(positions[i]));
  assert_ok(fb_evaluate(model, scratch, controls, again));
  assert_memory_equal(positions, again, sizeof positions);
}

static void values_outside_their_range_are_clamped_and_counted(void** state) {
  (void)state;
  const float wild[CONTROLS] = {1.5f, -INFINITY, 0.5f, 2, 1e30f}, within[CONTROLS] = {1, -1, 0.5f, 2, 1};
  float clamped[FLOATS], expected[FLOATS];
  assert_ok(fb_evaluate(model, scratch, wild, clamped));
  assert_int_equal(fb_clamped_count(scratch), 3);
  assert_ok(fb_evaluate(model, scratch, within, expected));
  assert_int_equal(fb_clamped_count(scratch), 0);
  assert_memory_equal(clamped, expected, sizeof clamped);
}

static void nan_is_refused_by_name(void** state) {
  (void)state;
  const float controls[CONTROLS] = {0, 0, 0, NAN, 0};
  float positions[FLOATS], before[FLOATS];
  for (int i = 0; i < FLOATS; ++i) positions[i] = before[i] = (float)i;
  assert_int_equal(fb_evaluate(model, scratch, controls, positions), FB_ERROR_NOT_FINITE);
  assert_non_null(strstr(fb_last_error(), "\"lid_close\""));
  assert_memory_equal(positions, before, sizeof positions);
}

static void wrong_arguments_are_refused(void** state) {
  (void)state;
  float controls[CONTROLS] = {0}, positions[FLOATS];
  assert_int_equal(fb_evaluate(NULL, scratch, controls, positions), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate(model, NULL, controls, positions), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate(model, scratch, NULL, positions), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_evaluate(model, scratch, controls, NULL), FB_ERROR_INVALID_ARGUMENT);
  fb_model* other = load_tiny();
  assert_int_equal(fb_evaluate(other, scratch, controls, positions), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "another model"));
  fb_release(other);
}

static void the_float_mode_of_the_host_changes_no_bit(void** state) {
  (void)state;
  const float controls[CONTROLS] = {0.3f, -0.7f, 0.9f, 1.1f, 0.6f};
  float expected[FLOATS], positions[FLOATS];
  assert_ok(fb_evaluate(model, scratch, controls, expected));
  fb_model* own = NULL;
  fb_scratch* of_own = NULL;
  fesetround(FE_UPWARD);
  const fb_status loaded = fb_load(FB_FIXTURE, NULL, &own);
  const fb_status created = fb_scratch_create(own, 1, &of_own);
  const fb_status evaluated = fb_evaluate(own, of_own, controls, positions);
  const int mode = fegetround();
  fesetround(FE_TONEAREST);
  assert_ok(loaded);
  assert_ok(created);
  assert_ok(evaluated);
  assert_int_equal(mode, FE_UPWARD);
  assert_memory_equal(positions, expected, sizeof positions);
  assert_true(fb_diagonal(own) == fb_diagonal(model));
  fb_scratch_destroy(of_own);
  fb_release(own);
}

static void a_scratch_keeps_its_model(void** state) {
  (void)state;
  fb_model* own = load_tiny();
  fb_scratch* of_own = NULL;
  float positions[FLOATS];
  assert_ok(fb_scratch_create(own, 1, &of_own));
  fb_release(own);
  assert_ok(fb_evaluate(own, of_own, fb_rest_controls(own), positions));
  fb_scratch_destroy(of_own);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rest_controls_give_the_rest_mesh),
      cmocka_unit_test(a_control_moves_vertices),
      cmocka_unit_test(values_outside_their_range_are_clamped_and_counted),
      cmocka_unit_test(nan_is_refused_by_name),
      cmocka_unit_test(wrong_arguments_are_refused),
      cmocka_unit_test(the_float_mode_of_the_host_changes_no_bit),
      cmocka_unit_test(a_scratch_keeps_its_model),
  };
  return cmocka_run_group_tests(tests, open_model, close_model);
}
