/* Loads a baked face, sets one control by its name, and prints where the vertices moved. */
#include <facebaker/facebaker.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(fb_status status) {
  if (status == FB_OK) return;
  fprintf(stderr, "%s: %s\n", fb_status_name(status), fb_last_error());
  exit(1);
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fprintf(stderr, "usage: hello_face FACE.fbk CONTROL VALUE\n");
    return 2;
  }
  fb_model* model;
  fb_scratch* scratch;
  uint32_t control;
  check(fb_load(argv[1], NULL, &model));
  check(fb_scratch_create(model, 1, &scratch));
  check(fb_find_control(model, argv[2], &control));

  const uint32_t controls = fb_control_count(model), vertices = fb_vertex_count(model);
  float* pose = malloc(controls * sizeof(float));
  float* positions = malloc(3 * (size_t)vertices * sizeof(float));
  if (!pose || !positions) return 1;
  const float* rest = fb_rest_positions(model);
  for (uint32_t c = 0; c < controls; ++c) pose[c] = fb_rest_controls(model)[c];
  pose[control] = strtof(argv[3], NULL);
  check(fb_evaluate(model, scratch, pose, positions));

  printf("%s: %u controls, %u vertices, FaceBaker %s\n", fb_name(model), controls, vertices, fb_version_string());
  if (fb_clamped_count(scratch)) printf("%s was clamped to its range\n", argv[2]);
  double largest = 0;
  uint32_t furthest = 0;
  for (uint32_t v = 0; v < vertices; ++v) {
    const float *to = positions + 3 * v, *from = rest + 3 * v;
    const double moved = sqrt(pow(to[0] - from[0], 2) + pow(to[1] - from[1], 2) + pow(to[2] - from[2], 2));
    if (moved > largest) {
      largest = moved;
      furthest = v;
    }
    if (v < 3) printf("vertex %u: %g %g %g\n", v, to[0], to[1], to[2]);
  }
  printf("largest displacement: vertex %u, %g %s\n", furthest, largest, fb_units(model));

  free(positions);
  free(pose);
  fb_scratch_destroy(scratch);
  fb_release(model);
  return 0;
}
