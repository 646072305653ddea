/* hash_archive POSES ARCHIVE[=HASH]...: through the public C interface, from the file on: the hash that dump_model and
 * hash_poses give for the same archive and number of poses, which must be the same on every machine. Fails if HASH is
 * another one, or if a batch gives other bits than pose by pose. */
#include <facebaker/facebaker.h>
#include <facebaker/facebaker_character.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct face {
  fb_model* model;
  fb_scratch* scratch;
  size_t controls, numbers, coefficients;
  size_t sockets, channels, joints, beside; /* floats of a pose; beside: their sum */
  int has_tangents;
} face;

/* The stream fb::Random(1) of core/base/random.h. */
static uint64_t mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

static float uniform(uint64_t* state) {
  return (float)(mix(*state += 0x9e3779b97f4a7c15u) >> 40) * (1.0f / 16777216.0f);
}

/* The poses of dump_model: from rest to all controls moved. */
static int draw(const fb_model* model, size_t poses, float* to) {
  uint64_t state = mix(mix(1) ^ 1);
  for (size_t pose = 0; pose < poses; ++pose)
    for (uint32_t c = 0; c < fb_control_count(model); ++c) {
      fb_control control;
      fb_control_init(&control);
      if (fb_control_at(model, c, &control) != FB_OK) return 0;
      const float range = (control.maximum - control.minimum) * uniform(&state);
      *to++ = uniform(&state) * (float)poses < (float)pose ? control.minimum + range : control.rest;
    }
  return 1;
}

/* FNV-1a over the bits of floats, lowest byte first. */
static void add(uint64_t* hash, const float* numbers, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    uint32_t bits;
    memcpy(&bits, numbers + i, sizeof bits);
    if (numbers[i] != numbers[i]) bits = 0x7fc00000u; /* those of a NaN depend on the machine */
    for (int shift = 0; shift < 32; shift += 8) *hash = (*hash ^ (bits >> shift & 255)) * 0x100000001b3u;
  }
}

/* Asks for what poses have beside vertices, at `to`: frames of sockets, channels, frames of driven joints. */
static void ask_beside(const face* f, fb_batch_desc* batch, float* to) {
  const size_t floats = batch->poses * f->beside, to_joints = f->sockets + f->channels;
  batch->socket_pose_stride = batch->channel_pose_stride = batch->joint_pose_stride = f->beside;
  batch->sockets = f->sockets ? to : NULL;
  batch->socket_floats = floats;
  batch->channels = f->channels ? to + f->sockets : NULL;
  batch->channel_floats = floats - f->sockets;
  batch->joints = f->joints ? to + to_joints : NULL;
  batch->joint_floats = floats - to_joints;
}

/* Hashes positions, normals, tangents, what is beside vertices, and coefficients, pose after pose, evaluated `together`
 * at a time. */
static int hash_poses(const face* f, const float* controls, size_t poses, size_t together, float* memory,
                      uint64_t* hash) {
  float *const positions = memory, *const normals = positions + together * f->numbers,
               *const tangents = normals + together * f->numbers, *const beside = tangents + together * f->numbers,
               *const weights = beside + together * f->beside;
  *hash = 0xcbf29ce484222325u;
  for (size_t first = 0; first < poses; first += together) {
    const size_t count = poses - first < together ? poses - first : together;
    fb_batch_desc batch;
    fb_batch_desc_init(&batch);
    batch.poses = count;
    batch.controls = controls + first * f->controls;
    batch.control_floats = count * f->controls;
    batch.positions = positions;
    batch.normals = normals;
    batch.position_floats = batch.normal_numbers = count * f->numbers;
    if (f->has_tangents) {
      batch.tangents = tangents;
      batch.tangent_numbers = count * f->numbers;
    }
    ask_beside(f, &batch, beside);
    if (fb_evaluate_batch(f->model, f->scratch, &batch) != FB_OK) return 0;
    for (size_t pose = 0; pose < count; ++pose) {
      if (fb_evaluate_coefficients(f->model, f->scratch, batch.controls + pose * f->controls, weights) != FB_OK)
        return 0;
      add(hash, positions + pose * f->numbers, f->numbers);
      add(hash, normals + pose * f->numbers, f->numbers);
      if (f->has_tangents) add(hash, tangents + pose * f->numbers, f->numbers);
      add(hash, beside + pose * f->beside, f->beside);
      add(hash, weights, f->coefficients);
    }
  }
  return 1;
}

static int run(const char* path, size_t poses, const char* expected) {
  face f = {0};
  uint64_t one = 0, batched = 1;
  float *controls = NULL, *memory = NULL;
  int done = 0;
  if (fb_load(path, NULL, &f.model) == FB_OK && fb_scratch_create(f.model, 1, &f.scratch) == FB_OK) {
    f.controls = fb_control_count(f.model);
    f.numbers = 3 * (size_t)fb_vertex_count(f.model);
    f.coefficients = fb_coefficient_count(f.model);
    f.has_tangents = fb_tangent_signs(f.model) != NULL;
    f.sockets = 12 * (size_t)fb_socket_count(f.model);
    f.channels = fb_channel_count(f.model);
    f.joints = 12 * (size_t)fb_driven_joint_count(f.model);
    f.beside = f.sockets + f.channels + f.joints;
    controls = malloc((poses * f.controls + 1) * sizeof *controls);
    memory = malloc((poses * (3 * f.numbers + f.beside) + f.coefficients + 1) * sizeof *memory);
    done = controls && memory && draw(f.model, poses, controls) && hash_poses(&f, controls, poses, 1, memory, &one) &&
           hash_poses(&f, controls, poses, poses, memory, &batched);
  }
  if (!done) fprintf(stderr, "hash_archive: %s: %s\n", path, fb_last_error());
  if (done && one != batched) fprintf(stderr, "hash_archive: %s: a batch gives other bits\n", path);
  if (done) fprintf(stderr, "%s ", fb_instruction_set(f.model));
  if (done) printf("%08lx%08lx\n", (unsigned long)(one >> 32), (unsigned long)(one & 0xffffffffu));
  free(controls);
  free(memory);
  fb_scratch_destroy(f.scratch);
  fb_release(f.model);
  return done && one == batched && (!expected || strtoull(expected, NULL, 16) == one);
}

int main(int argc, char** argv) {
  const size_t poses = argc > 2 ? strtoul(argv[1], NULL, 10) : 0;
  int same = poses > 0;
  if (!same) fprintf(stderr, "usage: hash_archive POSES ARCHIVE[=HASH]...\n");
  for (int i = 2; i < argc && poses > 0; ++i) {
    char* const equals = strrchr(argv[i], '=');
    if (equals) *equals = 0;
    same = run(argv[i], poses, equals ? equals + 1 : NULL) && same;
  }
  return same ? 0 : 1;
}
