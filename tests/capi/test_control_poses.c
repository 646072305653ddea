/* Poses blended in the space of controls, and controls found by the hash of their names. */
#include <math.h>
#include <string.h>

#include "capi_test.h"

enum { controls = 5 };
static fb_model* character;
static fb_control infos[controls];

static int load(void** state) {
  (void)state;
  if (fb_load(FB_CHARACTER, NULL, &character) != FB_OK || fb_control_count(character) != controls) return -1;
  for (uint32_t i = 0; i < controls; ++i) {
    fb_control_init(&infos[i]);
    if (fb_control_at(character, i, &infos[i]) != FB_OK) return -1;
  }
  return 0;
}

static int release(void** state) {
  (void)state;
  fb_release(character);
  return 0;
}

/* Each control a share of the way from one end of its range to the other. */
static void fill(float* pose, float share) {
  for (int i = 0; i < controls; ++i)
    pose[i] = infos[i].minimum + (0.1f * (float)i + share) / 1.5f * (infos[i].maximum - infos[i].minimum);
}

static void a_blend_lies_between(void** state) {
  (void)state;
  float from[controls], to[controls], blended[controls];
  fill(from, 0.1f);
  fill(to, 0.9f);
  assert_ok(fb_blend_controls(character, from, to, 0, blended));
  assert_memory_equal(blended, from, sizeof from);
  assert_ok(fb_blend_controls(character, from, to, 1, blended));
  assert_memory_equal(blended, to, sizeof to);
  assert_ok(fb_blend_controls(character, from, to, 0.25f, blended));
  for (int i = 0; i < controls; ++i)
    assert_true(fabsf(blended[i] - (0.75f * from[i] + 0.25f * to[i])) <= 1e-5f * (1 + fabsf(blended[i])));
  /* Beyond either end, and from values outside, a control stays in its range. */
  from[1] = INFINITY;
  to[2] = -INFINITY;
  for (int k = 0; k < 2; ++k) {
    assert_ok(fb_blend_controls(character, from, to, k ? 40.0f : -40.0f, blended));
    for (int i = 0; i < controls; ++i) assert_true(blended[i] >= infos[i].minimum && blended[i] <= infos[i].maximum);
  }
  assert_true(blended[0] == infos[0].maximum);
  assert_ok(fb_blend_controls(character, from, to, 0, blended));
  assert_true(blended[1] == infos[1].maximum);
  /* The result may lie where either pose does. */
  fill(from, 0.1f);
  fill(to, 0.9f);
  assert_ok(fb_blend_controls(character, from, to, 0.5f, blended));
  assert_ok(fb_blend_controls(character, from, to, 0.5f, to));
  assert_memory_equal(to, blended, sizeof to);
}

static void a_mirror_has_partners_exchanged(void** state) {
  (void)state;
  int pairs = 0;
  float from[controls], mirror[controls], again[controls];
  fill(from, 0.2f);
  assert_ok(fb_blend_controls(character, from, NULL, 1, mirror));
  for (int i = 0; i < controls; ++i) {
    const uint32_t m = infos[i].mirror;
    if (m == FB_NO_CONTROL) {
      assert_true(mirror[i] == from[i]);
      continue;
    }
    ++pairs;
    /* As far on its way from rest to the end of its range. */
    const float end = from[m] >= infos[m].rest ? infos[m].maximum : infos[m].minimum;
    const float own_end = from[m] >= infos[m].rest ? infos[i].maximum : infos[i].minimum;
    const float expected =
        infos[i].rest + (from[m] - infos[m].rest) / (end - infos[m].rest) * (own_end - infos[i].rest);
    assert_true(fabsf(mirror[i] - expected) <= 1e-5f * (1 + fabsf(expected)));
    assert_true(mirror[i] != from[i]);
  }
  assert_true(pairs >= 2);
  assert_ok(fb_blend_controls(character, mirror, NULL, 1, again));
  for (int i = 0; i < controls; ++i) assert_true(fabsf(again[i] - from[i]) <= 1e-5f * (1 + fabsf(from[i])));
  assert_ok(fb_blend_controls(character, from, NULL, 0.5f, again));
  for (int i = 0; i < controls; ++i)
    assert_true(fabsf(again[i] - (from[i] + mirror[i]) / 2) <= 1e-5f * (1 + fabsf(again[i])));
  assert_ok(fb_blend_controls(character, from, NULL, 0.5f, from));
  assert_memory_equal(from, again, sizeof from);
}

static void wrong_poses_are_refused(void** state) {
  (void)state;
  float from[controls], to[controls], blended[controls] = {7, 7, 7, 7, 7};
  fill(from, 0.2f);
  fill(to, 0.4f);
  to[3] = NAN;
  assert_int_equal(fb_blend_controls(character, from, to, 0.5f, blended), FB_ERROR_NOT_FINITE);
  assert_non_null(strstr(fb_last_error(), infos[3].name));
  assert_int_equal(fb_blend_controls(character, to, NULL, 0.5f, blended), FB_ERROR_NOT_FINITE);
  assert_int_equal(fb_blend_controls(character, from, NULL, NAN, blended), FB_ERROR_NOT_FINITE);
  assert_int_equal(fb_blend_controls(character, from, NULL, INFINITY, blended), FB_ERROR_NOT_FINITE);
  assert_int_equal(fb_blend_controls(NULL, from, NULL, 0, blended), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_blend_controls(character, NULL, to, 0, blended), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_blend_controls(character, from, NULL, 0, NULL), FB_ERROR_INVALID_ARGUMENT);
  for (int i = 0; i < controls; ++i) assert_true(blended[i] == 7);
}

static void controls_are_found_by_hash(void** state) {
  (void)state;
  /* As other programs compute XXH64 with seed 0. */
  assert_true(fb_name_hash("") == UINT64_C(0xef46db3751d8e999));
  assert_true(fb_name_hash(NULL) == fb_name_hash(""));
  assert_true(fb_name_hash("jaw_open") == UINT64_C(0x251683c4c174b423));
  for (uint32_t i = 0; i < controls; ++i) {
    uint32_t index = 77;
    assert_ok(fb_find_control_hash(character, fb_name_hash(infos[i].name), &index));
    assert_int_equal(index, i);
  }
  uint32_t index = 77;
  assert_int_equal(fb_find_control_hash(character, 42, &index), FB_ERROR_NOT_FOUND);
  assert_non_null(strstr(fb_last_error(), "000000000000002a"));
  assert_int_equal(index, 77);
  assert_int_equal(fb_find_control_hash(NULL, 42, &index), FB_ERROR_INVALID_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_blend_lies_between),
      cmocka_unit_test(a_mirror_has_partners_exchanged),
      cmocka_unit_test(wrong_poses_are_refused),
      cmocka_unit_test(controls_are_found_by_hash),
  };
  return cmocka_run_group_tests(tests, load, release);
}
