/* What the native library gives, for the tests of the npm package.
 *   native_poses dump ARCHIVE POSES OUT   random poses and all that is evaluated of them, see expected_poses.ts
 *   native_poses refuse ARCHIVE...        a line each: status, tab, message
 *   native_poses time ARCHIVE POSES       microseconds a pose, median of rounds over the poses of dump */
#include <facebaker/facebaker.h>
#include <facebaker/facebaker_character.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "native_helpers.h"

static fb_status load(const char* path, fb_model** model) {
  FILE* const file = fopen(path, "rb");
  if (!file) {
    perror(path);
    exit(3);
  }
  fseek(file, 0, SEEK_END);
  const long size = ftell(file);
  rewind(file);
  void* const bytes = allocate((size_t)size);
  if (fread(bytes, 1, (size_t)size, file) != (size_t)size) exit(3);
  fclose(file);
  const fb_status status = fb_load_memory(bytes, (size_t)size, NULL, model);
  free(bytes);
  return status;
}

/* Even poses move every control, odd ones a fifth of them; every eighth goes beyond the ranges. */
static float* draw_poses(const fb_model* model, uint32_t poses) {
  const uint32_t controls = fb_control_count(model);
  float* const drawn = allocate(sizeof(float) * poses * controls);
  for (uint32_t p = 0; p < poses; ++p)
    for (uint32_t c = 0; c < controls; ++c) {
      fb_control control;
      fb_control_init(&control);
      check(fb_control_at(model, c, &control));
      const float moved = draw(), value = draw() * (p % 8 == 7 ? 1.5f : 1.0f);
      const int rests = p % 2 == 1 && moved > 0.2f;
      drawn[p * controls + c] = rests ? control.rest : control.minimum + value * (control.maximum - control.minimum);
    }
  return drawn;
}

static void dump(const char* path, uint32_t poses, const char* out) {
  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  check(load(path, &model));
  check(fb_scratch_create(model, 1, &scratch));
  const uint32_t vertices = fb_vertex_count(model), coefficients = fb_coefficient_count(model),
                 sockets = fb_socket_count(model), channels = fb_channel_count(model),
                 errors = fb_error_region_count(model) > 0 ? 1 + fb_error_region_count(model) : 0,
                 has_uvs = fb_uv_count(model) > 0, joints = fb_driven_joint_count(model),
                 header[] = {poses, fb_control_count(model), vertices, coefficients, sockets, channels, errors, has_uvs,
                             joints};
  float* const controls = draw_poses(model, poses);
  const uint64_t surface = 3 * (uint64_t)vertices * poses;
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = poses;
  desc.controls = controls;
  desc.control_floats = (uint64_t)poses * header[1];
  desc.positions = allocate(sizeof(float) * (desc.position_floats = surface));
  desc.normals = allocate(sizeof(float) * (desc.normal_numbers = surface));
  if (has_uvs) desc.tangents = allocate(sizeof(float) * (desc.tangent_numbers = surface));
  if (sockets) desc.sockets = allocate(sizeof(float) * (desc.socket_floats = 12 * (uint64_t)sockets * poses));
  if (channels) desc.channels = allocate(sizeof(float) * (desc.channel_floats = (uint64_t)channels * poses));
  if (errors) desc.expected_errors = allocate(sizeof(float) * (desc.expected_error_floats = (uint64_t)errors * poses));
  if (errors) desc.outside = allocate(sizeof(uint32_t) * poses);
  desc.bounds = allocate(sizeof(float) * (desc.bounds_floats = 6 * (uint64_t)poses));
  if (joints) desc.joints = allocate(sizeof(float) * (desc.joint_floats = 12 * (uint64_t)joints * poses));
  check(fb_evaluate_batch(model, scratch, &desc));
  fb_batch_desc unskinned;
  fb_batch_desc_init(&unskinned);
  unskinned.poses = poses;
  unskinned.controls = controls;
  unskinned.control_floats = desc.control_floats;
  unskinned.positions = allocate(sizeof(float) * (unskinned.position_floats = surface));
  unskinned.unskinned = 1;
  if (joints) check(fb_evaluate_batch(model, scratch, &unskinned));
  float* const posed = allocate(sizeof(float) * poses * coefficients);
  for (uint32_t p = 0; p < poses; ++p)
    check(fb_evaluate_coefficients(model, scratch, controls + (size_t)p * header[1], posed + (size_t)p * coefficients));
  FILE* const file = fopen(out, "wb");
  if (!file) exit(3);
  fwrite(header, sizeof header, 1, file);
  fwrite(controls, sizeof(float), desc.control_floats, file);
  fwrite(desc.positions, sizeof(float), surface, file);
  fwrite(desc.normals, sizeof(float), surface, file);
  if (has_uvs) fwrite(desc.tangents, sizeof(float), surface, file);
  fwrite(posed, sizeof(float), (size_t)poses * coefficients, file);
  fwrite(desc.bounds, sizeof(float), desc.bounds_floats, file);
  if (sockets) fwrite(desc.sockets, sizeof(float), desc.socket_floats, file);
  if (channels) fwrite(desc.channels, sizeof(float), desc.channel_floats, file);
  if (errors) fwrite(desc.expected_errors, sizeof(float), desc.expected_error_floats, file);
  if (errors) fwrite(desc.outside, sizeof(uint32_t), poses, file);
  if (joints) fwrite(desc.joints, sizeof(float), desc.joint_floats, file);
  if (joints) fwrite(unskinned.positions, sizeof(float), surface, file);
  if (fclose(file) != 0) exit(3);
}

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e6 * (double)time.tv_sec + 1e-3 * (double)time.tv_nsec;
}

static int ascending(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static void measure(const char* path, uint32_t poses) {
  enum { ROUNDS = 31 };
  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  check(load(path, &model));
  check(fb_scratch_create(model, 1, &scratch));
  const float* const controls = draw_poses(model, poses);
  float* const positions = allocate(sizeof(float) * 3 * fb_vertex_count(model));
  for (uint32_t first = 0; first < 2; ++first) {
    double times[ROUNDS];
    for (int round = 0; round < ROUNDS; ++round) {
      const double begin = now();
      for (uint32_t p = first; p < poses; p += 2)
        check(fb_evaluate(model, scratch, controls + (size_t)p * fb_control_count(model), positions));
      times[round] = (now() - begin) / (poses / 2);
    }
    qsort(times, ROUNDS, sizeof(double), ascending);
    printf("%s %.2f\n", first == 0 ? "all" : "fifth", times[ROUNDS / 2]);
  }
  printf("instructions %s\n", fb_instruction_set(model));
}

int main(int count, char** arguments) {
  if (count == 5 && !strcmp(arguments[1], "dump")) {
    dump(arguments[2], (uint32_t)atoi(arguments[3]), arguments[4]);
  } else if (count == 4 && !strcmp(arguments[1], "time")) {
    measure(arguments[2], (uint32_t)atoi(arguments[3]));
  } else if (count > 2 && !strcmp(arguments[1], "refuse")) {
    for (int i = 2; i < count; ++i) {
      fb_model* model = NULL;
      const fb_status status = load(arguments[i], &model);
      printf("%d\t%s\n", (int)status, status == FB_OK ? "" : fb_last_error());
      fb_release(model);
    }
  } else {
    fprintf(stderr, "usage: native_poses dump ARCHIVE POSES OUT | time ARCHIVE POSES | refuse ARCHIVE...\n");
    return 2;
  }
  return 0;
}
