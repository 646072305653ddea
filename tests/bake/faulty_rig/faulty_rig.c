/* The toy rig, with the one fault that the environment variable FB_FAULT names. */
#define fb_rig_open toy_rig_open
#include "../toy_rig/toy_rig.c"
#undef fb_rig_open

#include <stddef.h>
#include <stdio.h>
#include <time.h>

/* Of each thread, because tests of ranks open the rig in several at once. */
static __thread fb_rig_control faulty_controls[controls];
static __thread fb_rig_clip faulty_clips[shots];
static __thread float faulty_values[shot_frames * controls];
static __thread float faulty_rest[3 * vertices];
static __thread uint32_t faulty_sizes[polygons], faulty_corners[4 * quads + 3];
static int counted; /* poses evaluated so far, for faults that show late */

/* Some faults fail, or give NaN, for the one pose in which browTwist is -0.5. */
static int marked(const float* values) {
  return values[1] == -0.5f;
}

static fb_status fail_on_marked(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                uint32_t message_size) {
  for (uint64_t p = 0; p < poses; ++p)
    if (marked(values + p * controls)) {
      snprintf(message, message_size, "the twist solver did not converge");
      return FB_ERROR_RIG;
    }
  return toy_evaluate(user, poses, values, positions, message, message_size);
}

static fb_status fail_without_words(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                    uint32_t message_size) {
  const fb_status status = fail_on_marked(user, poses, values, positions, message, message_size);
  if (status != FB_OK) message[0] = 0;
  return status;
}

static fb_status fail_on_blocks(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                uint32_t message_size) {
  if (poses > 2) {
    snprintf(message, message_size, "too many poses for me");
    return FB_ERROR_LIMIT;
  }
  return toy_evaluate(user, poses, values, positions, message, message_size);
}

static fb_status nan_on_marked(void* user, uint64_t poses, const float* values, float* positions, char* message,
                               uint32_t message_size) {
  toy_evaluate(user, poses, values, positions, message, message_size);
  for (uint64_t p = 0; p < poses; ++p)
    if (marked(values + p * controls)) positions[p * 3 * vertices + 3 * 17 + 1] = NAN;
  return FB_OK;
}

/* For a minute. */
static fb_status stuck_on_marked(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                 uint32_t message_size) {
  const struct timespec time = {60, 0};
  for (uint64_t p = 0; p < poses; ++p)
    if (marked(values + p * controls)) nanosleep(&time, NULL);
  return toy_evaluate(user, poses, values, positions, message, message_size);
}

static fb_status first_pose_only(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                 uint32_t message_size) {
  (void)poses;
  return toy_evaluate(user, 1, values, positions, message, message_size);
}

static fb_status bulge_more(void* user, uint64_t poses, const float* values, float* positions, char* message,
                            uint32_t message_size) {
  toy_evaluate(user, poses, values, positions, message, message_size);
  for (uint64_t p = 0; p < poses; ++p)
    if (values[p * controls + 1] != 0) positions[p * 3 * vertices] += 1;
  return FB_OK;
}

/* More than half a millisecond a pose, so that evaluations are kept in a file. */
static fb_status evaluate_slowly(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                 uint32_t message_size) {
  const clock_t start = clock();
  while ((double)(clock() - start) < 0.0006 * CLOCKS_PER_SEC * (double)poses) continue;
  return toy_evaluate(user, poses, values, positions, message, message_size);
}

/* 20 ms a pose, without load: what takes long on another machine. */
static fb_status evaluate_asleep(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                 uint32_t message_size) {
  const struct timespec time = {0, 20000000};
  for (uint64_t p = 0; p < poses; ++p) nanosleep(&time, NULL);
  return toy_evaluate(user, poses, values, positions, message, message_size);
}

static fb_status bulge_slowly(void* user, uint64_t poses, const float* values, float* positions, char* message,
                              uint32_t message_size) {
  evaluate_slowly(user, poses, values, positions, message, message_size);
  return bulge_more(user, poses, values, positions, message, message_size);
}

/* Breaks when two threads are inside at once, which thread sanitizers see as well. */
static fb_status count_calls(void* user, uint64_t poses, const float* values, float* positions, char* message,
                             uint32_t message_size) {
  const int before = counted;
  const fb_status status = toy_evaluate(user, poses, values, positions, message, message_size);
  if (counted != before) {
    snprintf(message, message_size, "called by two threads at once");
    return FB_ERROR_RIG;
  }
  counted = before + (int)poses;
  return status;
}

static void copy_declarations(fb_rig* rig) {
  memcpy(faulty_controls, rig->controls, sizeof faulty_controls);
  memcpy(faulty_clips, rig->clips, sizeof faulty_clips);
  memcpy(faulty_values, rig->clips[1].controls, sizeof faulty_values);
  memcpy(faulty_rest, rig->rest_positions, sizeof faulty_rest);
  memcpy(faulty_sizes, rig->polygon_sizes, sizeof faulty_sizes);
  memcpy(faulty_corners, rig->polygon_corners, sizeof faulty_corners);
  faulty_clips[1].controls = faulty_values;
  rig->controls = faulty_controls;
  rig->clips = faulty_clips;
  rig->rest_positions = faulty_rest;
  rig->polygon_sizes = faulty_sizes;
  rig->polygon_corners = faulty_corners;
}

/* Corners have the first three texture coordinates in turn. */
static void give_uvs(fb_rig* rig, uint32_t count) {
  static const float uvs[6] = {0, 0, 0.5f, 0, 0.5f, 1};
  static uint32_t of_corners[sizeof faulty_corners / sizeof *faulty_corners];
  for (size_t c = 0; c < sizeof of_corners / sizeof *of_corners; ++c) of_corners[c] = (uint32_t)(c % 3);
  rig->uv_count = count;
  rig->uvs = uvs;
  rig->uv_corners = of_corners;
}

/* As if compiled with a later header, whose controls and clips have a field more. */
static void lengthen(fb_rig* rig) {
  static struct {
    fb_rig_control control;
    uint64_t later;
  } long_controls[controls];
  static struct {
    fb_rig_clip clip;
    uint64_t later;
  } long_clips[shots];
  for (int c = 0; c < controls; ++c) long_controls[c].control = rig->controls[c], long_controls[c].later = UINT64_MAX;
  for (int s = 0; s < shots; ++s) long_clips[s].clip = rig->clips[s], long_clips[s].later = UINT64_MAX;
  rig->controls = &long_controls->control;
  rig->clips = &long_clips->clip;
  rig->control_stride = sizeof *long_controls;
  rig->clip_stride = sizeof *long_clips;
}

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size);

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size) {
  const char* fault = getenv("FB_FAULT");
  if (!fault) fault = "";
#define FAULT(name) else if (strcmp(fault, name) == 0)
  if (strcmp(fault, "open fails") == 0) {
    snprintf(message, message_size, "the licence server is asleep");
    return FB_ERROR_RIG;
  }
  const fb_status status = toy_rig_open(path, rig, message, message_size);
  if (status != FB_OK) return status;
  copy_declarations(rig);
  if (!*fault) return FB_OK;
  /* a host that cannot read the rig cannot destroy it either */
  FAULT("abi") free(rig->user), rig->abi = FB_RIG_ABI + 1;
  FAULT("older abi") free(rig->user), rig->abi = FB_RIG_ABI - 1;
  FAULT("struct size") free(rig->user), rig->struct_size = 8;
  FAULT("control stride") rig->control_stride = offsetof(fb_rig_control, rest);
  FAULT("clip stride") rig->clip_stride = 0;
  FAULT("longer structs") lengthen(rig);
  FAULT("no name") rig->name = NULL;
  FAULT("no units") rig->units = "";
  FAULT("up axis") rig->up_axis = "x";
  FAULT("no evaluate") rig->evaluate = NULL;
  FAULT("no controls") rig->control_count = 0;
  FAULT("null controls") rig->controls = NULL;
  FAULT("no vertices") rig->vertex_count = 0;
  FAULT("null rest") rig->rest_positions = NULL;
  FAULT("no polygons") rig->polygon_count = 0;
  FAULT("null corners") rig->polygon_corners = NULL;
  FAULT("null control name") faulty_controls[2].name = NULL;
  FAULT("double control") faulty_controls[2].name = "jawOpen";
  FAULT("range") faulty_controls[2].maximum = -1;
  FAULT("range nan") faulty_controls[2].minimum = NAN;
  FAULT("default") faulty_controls[2].rest = 3;
  FAULT("two corners") faulty_sizes[5] = 2;
  FAULT("huge polygon") faulty_sizes[5] = 1000000000u;
  FAULT("bad corner") faulty_corners[9] = vertices;
  FAULT("rest nan") faulty_rest[30] = NAN;
  FAULT("rest moved") faulty_rest[3 * 20] += 0.01f;
  FAULT("texture") give_uvs(rig, 3);
  FAULT("texture beyond an older struct") give_uvs(rig, 3), rig->struct_size = offsetof(fb_rig, uv_count);
  FAULT("texture in an older struct") give_uvs(rig, 3), rig->struct_size = offsetof(fb_rig, preferred_block);
  FAULT("preferred block") rig->preferred_block = 7;
  FAULT("huge preferred block") rig->preferred_block = UINT32_MAX;
  FAULT("preferred block beyond an older struct")
  rig->preferred_block = 7, rig->struct_size = offsetof(fb_rig, preferred_block);
  FAULT("version") rig->version = "12b";
  FAULT("version beyond an older struct") rig->version = "12b", rig->struct_size = offsetof(fb_rig, version);
  FAULT("null texture") give_uvs(rig, 3), rig->uvs = NULL;
  FAULT("texture corner") give_uvs(rig, 2);
  FAULT("null clips") rig->clips = NULL;
  FAULT("double clip") faulty_clips[1].name = "talk";
  FAULT("clip kind") faulty_clips[1].kind = 5;
  FAULT("clip split") faulty_clips[1].split = -1;
  FAULT("clip fps") faulty_clips[1].fps = 0;
  FAULT("clip empty") faulty_clips[1].frames = 0;
  FAULT("clip null") faulty_clips[1].controls = NULL;
  FAULT("clip range") faulty_values[4 * controls + 3] = 1.5f;
  FAULT("clip nan") faulty_values[4 * controls + 3] = NAN;
  FAULT("fails on a pose") rig->evaluate = fail_on_marked;
  FAULT("fails without words") rig->evaluate = fail_without_words;
  FAULT("fails on blocks") rig->evaluate = fail_on_blocks;
  FAULT("stuck on a pose") rig->evaluate = stuck_on_marked;
  FAULT("nan on a pose") rig->evaluate = nan_on_marked;
  FAULT("first pose only") rig->evaluate = first_pose_only;
  FAULT("slow") rig->evaluate = evaluate_slowly;
  FAULT("sleeps") rig->flags = 0, rig->evaluate = evaluate_asleep;
  FAULT("other shape") rig->evaluate = bulge_more;
  FAULT("slow with a version") rig->flags = 0, rig->version = "1", rig->evaluate = evaluate_slowly;
  FAULT("slow with another version") rig->flags = 0, rig->version = "2", rig->evaluate = bulge_slowly;
  FAULT("one thread only") rig->flags = 0, rig->evaluate = count_calls;
  else {
    snprintf(message, message_size, "there is no fault called %s", fault);
    return FB_ERROR_INVALID_ARGUMENT;
  }
  return FB_OK;
}
