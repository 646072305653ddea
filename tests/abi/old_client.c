/* A program as it was built against FaceBaker 0.9 at its beginning: it includes none of today's headers, but keeps the
 * prototypes, layouts and sizes of then, and is linked against today's library. A struct that has grown since must be
 * filled and read up to the size that this program knows, and no further.
 *   abi_old_client FACE.fbk */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int32_t fb_load(const char* path, const void* desc, void** model);
void fb_release(const void* model);
const char* fb_last_error(void);
uint32_t fb_vertex_count(const void* model);
uint32_t fb_control_count(const void* model);
int32_t fb_control_at(const void* model, uint32_t index, void* control);
int32_t fb_scratch_create(const void* model, uint32_t workers, void** scratch);
void fb_scratch_destroy(void* scratch);
int32_t fb_evaluate(const void* model, void* scratch, const float* controls, float* positions);
int32_t fb_evaluate_batch(const void* model, void* scratch, const void* desc);

struct old_control {
  uint32_t struct_size, reserved;
  const char *name, *group;
  float minimum, maximum, rest;
  uint32_t mirror;
  const char *arkit, *facs, *unit;
};

struct old_batch_desc { /* as far as this program knows it: an older one still */
  uint32_t struct_size, threads;
  uint64_t poses;
  const float* controls;
  uint64_t control_floats, control_stride;
  void* positions;
  uint64_t position_floats, pose_stride, vertex_stride;
};

typedef void (*fill_function)(void* to, uint32_t struct_size);
#define OLD(name, bytes) \
  { #name, name##_fill, bytes }
#define FILL(name) void name##_fill(void* to, uint32_t struct_size)
FILL(fb_archive_info);
FILL(fb_bake_desc);
FILL(fb_batch_desc);
FILL(fb_channel);
FILL(fb_check_desc);
FILL(fb_check_result);
FILL(fb_clip);
FILL(fb_clip_errors);
FILL(fb_compare_desc);
FILL(fb_control);
FILL(fb_decompose_desc);
FILL(fb_decomposition_info);
FILL(fb_eval_desc);
FILL(fb_exact_pose);
FILL(fb_failure);
FILL(fb_image);
FILL(fb_joint);
FILL(fb_layer);
FILL(fb_level);
FILL(fb_load_desc);
FILL(fb_material);
FILL(fb_mesh);
FILL(fb_method);
FILL(fb_pack_desc);
FILL(fb_pack_result);
FILL(fb_pose_block);
FILL(fb_region);
FILL(fb_row_block);
FILL(fb_sample_desc);
FILL(fb_sample_result);
FILL(fb_section);
FILL(fb_socket);
FILL(fb_source_desc);
FILL(fb_source_info);
FILL(fb_spreader);
FILL(fb_verify_result);

/* Their sizes where pointers have 64 bits. */
static const struct {
  const char* name;
  fill_function fill;
  uint32_t bytes;
} old_structs[] = {
    OLD(fb_archive_info, 152), OLD(fb_bake_desc, 256),    OLD(fb_batch_desc, 312),    OLD(fb_channel, 40),
    OLD(fb_check_desc, 40),    OLD(fb_check_result, 40),  OLD(fb_clip, 48),           OLD(fb_clip_errors, 88),
    OLD(fb_compare_desc, 104), OLD(fb_control, 64),       OLD(fb_decompose_desc, 64), OLD(fb_decomposition_info, 40),
    OLD(fb_eval_desc, 56),     OLD(fb_exact_pose, 24),    OLD(fb_failure, 24),        OLD(fb_image, 40),
    OLD(fb_joint, 112),        OLD(fb_layer, 24),         OLD(fb_level, 56),          OLD(fb_load_desc, 112),
    OLD(fb_material, 72),      OLD(fb_mesh, 48),          OLD(fb_method, 272),        OLD(fb_pack_desc, 128),
    OLD(fb_pack_result, 120),  OLD(fb_pose_block, 88),    OLD(fb_region, 40),         OLD(fb_row_block, 16),
    OLD(fb_sample_desc, 128),  OLD(fb_sample_result, 48), OLD(fb_section, 32),        OLD(fb_socket, 80),
    OLD(fb_source_desc, 104),  OLD(fb_source_info, 120),  OLD(fb_spreader, 32),       OLD(fb_verify_result, 32),
};

enum { room = 1024, canary = 0xa5 };

static void fail_with(const char* what, const char* why) {
  fprintf(stderr, "abi_old_client: %s: %s\n", what, why);
  exit(1);
}

static void check(int32_t status, const char* what) {
  if (status != 0) fail_with(what, fb_last_error());
}

static void check_canary(const unsigned char* bytes, size_t begin, const char* what) {
  for (size_t i = begin; i < room; ++i)
    if (bytes[i] != canary) fail_with(what, "was written beyond the size that this program knows");
}

/* Every struct, up to its old size, and cut where it had no more than its first 8 bytes. */
static void fill_old_structs(void) {
  static union {
    unsigned char bytes[room];
    uint64_t aligned;
  } memory;
  for (size_t i = 0; i < sizeof old_structs / sizeof *old_structs; ++i) {
    const uint32_t sizes[2] = {old_structs[i].bytes, 8};
    for (int s = 0; s < 2; ++s) {
      uint32_t size;
      memset(memory.bytes, canary, room);
      old_structs[i].fill(memory.bytes, sizes[s]);
      memcpy(&size, memory.bytes, sizeof size);
      if (size != sizes[s]) fail_with(old_structs[i].name, "does not keep the size that this program knows");
      check_canary(memory.bytes, sizes[s], old_structs[i].name);
    }
  }
}

/* Controls at half of their range: all of them move. */
static float* read_controls(const void* model) {
  const uint32_t count = fb_control_count(model);
  float* controls = malloc(sizeof(float) * count);
  if (!controls) fail_with("controls", "no memory");
  for (uint32_t i = 0; i < count; ++i) {
    union {
      unsigned char bytes[room];
      struct old_control control;
    } memory;
    memset(memory.bytes, canary, room);
    fb_control_fill(memory.bytes, sizeof(struct old_control));
    check(fb_control_at(model, i, memory.bytes), "fb_control_at");
    check_canary(memory.bytes, sizeof(struct old_control), "fb_control_at");
    if (!memory.control.name[0] || !(memory.control.minimum <= memory.control.rest) ||
        !(memory.control.rest <= memory.control.maximum) || !memory.control.unit)
      fail_with("fb_control_at", "a control is not as it was");
    controls[i] = (memory.control.minimum + memory.control.maximum) / 2;
  }
  return controls;
}

int main(int argc, char** argv) {
  if (argc != 2) return fprintf(stderr, "usage: abi_old_client FACE.fbk\n"), 2;
  if (sizeof(void*) == 8) fill_old_structs();
  void *model, *scratch;
  check(fb_load(argv[1], NULL, &model), "fb_load");
  check(fb_scratch_create(model, 1, &scratch), "fb_scratch_create");
  const uint64_t numbers = 3 * (uint64_t)fb_vertex_count(model);
  float* controls = read_controls(model);
  float* positions = malloc(2 * numbers * sizeof(float));
  if (!positions) fail_with("positions", "no memory");
  check(fb_evaluate(model, scratch, controls, positions), "fb_evaluate");

  /* Beyond the end of its struct lies nothing that the library may read: it would be refused there. */
  union {
    unsigned char bytes[room];
    struct old_batch_desc desc;
  } batch;
  memset(batch.bytes, canary, room);
  fb_batch_desc_fill(batch.bytes, sizeof(struct old_batch_desc));
  batch.desc.poses = 1;
  batch.desc.controls = controls;
  batch.desc.control_floats = fb_control_count(model);
  batch.desc.positions = positions + numbers;
  batch.desc.position_floats = numbers;
  check(fb_evaluate_batch(model, scratch, batch.bytes), "fb_evaluate_batch");
  check_canary(batch.bytes, sizeof(struct old_batch_desc), "fb_evaluate_batch");
  if (memcmp(positions, positions + numbers, numbers * sizeof(float)) != 0)
    fail_with("fb_evaluate_batch", "another pose than fb_evaluate");

  free(positions);
  free(controls);
  fb_scratch_destroy(scratch);
  fb_release(model);
  return 0;
}
