/* What every test of the C ABI begins with. */
#ifndef CAPI_TEST_H
#define CAPI_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <facebaker/facebaker.h>

#define assert_ok(call) assert_int_equal((call), FB_OK)

/* The fixture, tiny_packed_model() of tests/test_models.h: 5 controls, 30 vertices. */
static inline fb_model* load_tiny(void) {
  fb_model* model = NULL;
  assert_ok(fb_load(FB_FIXTURE, NULL, &model));
  return model;
}

#endif
