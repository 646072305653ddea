/* The time of poses by calls from C, for the C# test to compare its own with in one process. */
#define _POSIX_C_SOURCE 200809L
#include <facebaker/facebaker.h>
#include <stdlib.h>
#include <time.h>

double time_evaluate(const char* path, uint32_t calls);

/** Nanoseconds of a call of fb_evaluate, the mean of so many, at the upper end of every control; below 0: it failed. */
double time_evaluate(const char* path, uint32_t calls) {
  fb_model* face;
  fb_scratch* scratch;
  if (fb_load(path, NULL, &face) || fb_scratch_create(face, 1, &scratch)) return -1;
  float* controls = calloc(fb_control_count(face), sizeof(float));
  float* positions = calloc(3 * (size_t)fb_vertex_count(face), sizeof(float));
  if (!controls || !positions) return -1;
  fb_control control;
  fb_control_init(&control);
  for (uint32_t i = 0; i < fb_control_count(face); ++i) {
    fb_control_at(face, i, &control);
    controls[i] = control.maximum;
  }
  fb_evaluate(face, scratch, controls, positions);
  struct timespec begin, end;
  int failed = 0;
  clock_gettime(CLOCK_MONOTONIC, &begin);
  for (uint32_t i = 0; i < calls; ++i) failed |= fb_evaluate(face, scratch, controls, positions) != FB_OK;
  clock_gettime(CLOCK_MONOTONIC, &end);
  free(controls), free(positions);
  fb_scratch_destroy(scratch);
  fb_release(face);
  if (failed) return -1;
  return ((double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec)) / calls;
}
