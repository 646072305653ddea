/* The fixture in POSES poses, which the test defines, as one batch; WORKERS may pose at once. */
#ifndef BATCH_FIXTURE_H
#define BATCH_FIXTURE_H

#include "capi_test.h"

#define CONTROLS 5
#define VERTICES 30
#define FLOATS 90

static fb_model* model;
static fb_scratch* scratch;
static float controls[POSES * CONTROLS];
static float expected[POSES * FLOATS]; /* pose by pose through fb_evaluate */

static int open_model(void** state) {
  (void)state;
  model = load_tiny();
  if (fb_scratch_create(model, WORKERS, &scratch) != FB_OK) return -1;
  for (int i = 0; i < POSES * CONTROLS; ++i) controls[i] = (float)(i * 37 % 101) / 80 - 0.125f;
  for (int p = 0; p < POSES; ++p)
    if (fb_evaluate(model, scratch, controls + p * CONTROLS, expected + p * FLOATS) != FB_OK) return -1;
  return 0;
}

static int close_model(void** state) {
  (void)state;
  fb_scratch_destroy(scratch);
  fb_release(model);
  return 0;
}

static fb_batch_desc describe(void* positions, uint64_t numbers) {
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * CONTROLS;
  desc.positions = positions;
  desc.position_floats = numbers;
  return desc;
}

#endif
