/* The layout of the structs of fb_check on 64-bit systems, as test_layout.c has it of the others. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>

#define assert_at(type, field, offset) assert_int_equal(offsetof(type, field), offset)

static void layout_of_checks(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_check_desc), 40);
  assert_at(fb_check_desc, struct_size, 0);
  assert_at(fb_check_desc, threads, 4);
  assert_at(fb_check_desc, directory, 8);
  assert_at(fb_check_desc, callbacks, 16);

  assert_int_equal(sizeof(fb_check_result), 40);
  assert_at(fb_check_result, struct_size, 0);
  assert_at(fb_check_result, bakeable, 4);
  assert_at(fb_check_result, faults, 8);
  assert_at(fb_check_result, warnings, 16);
  assert_at(fb_check_result, poses, 24);
  assert_at(fb_check_result, evaluated, 32);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(layout_of_checks)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
