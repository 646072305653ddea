/* The toy rig, except for the one thing the environment variable FB_LIE names. */
#define fb_rig_open toy_rig_open
#include "../toy_rig/toy_rig.c"
#undef fb_rig_open

#include <stddef.h>
#include <stdio.h>

static fb_rig_control lying_controls[controls];
static fb_rig_clip lying_clips[shots];
static float lying_values[shot_frames * controls];
static float lying_rest[3 * vertices];
static uint32_t lying_sizes[polygons], lying_corners[4 * quads + 3];
static int counted; /* poses evaluated one after the other, for the liars that fail late */

/* browTwist says what to do: the liars fail or give NaN for the one pose in which it is -0.5. */
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
  memcpy(lying_controls, rig->controls, sizeof lying_controls);
  memcpy(lying_clips, rig->clips, sizeof lying_clips);
  memcpy(lying_values, rig->clips[1].controls, sizeof lying_values);
  memcpy(lying_rest, rig->rest_positions, sizeof lying_rest);
  memcpy(lying_sizes, rig->polygon_sizes, sizeof lying_sizes);
  memcpy(lying_corners, rig->polygon_corners, sizeof lying_corners);
  lying_clips[1].controls = lying_values;
  rig->controls = lying_controls;
  rig->clips = lying_clips;
  rig->rest_positions = lying_rest;
  rig->polygon_sizes = lying_sizes;
  rig->polygon_corners = lying_corners;
}

/* Corners have the first three texture coordinates in turn. */
static void give_uvs(fb_rig* rig, uint32_t count) {
  static const float uvs[6] = {0, 0, 0.5f, 0, 0.5f, 1};
  static uint32_t of_corners[sizeof lying_corners / sizeof *lying_corners];
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
  const char* lie = getenv("FB_LIE");
  if (!lie) lie = "";
#define LIE(name) else if (strcmp(lie, name) == 0)
  if (strcmp(lie, "open fails") == 0) {
    snprintf(message, message_size, "the licence server is asleep");
    return FB_ERROR_RIG;
  }
  const fb_status status = toy_rig_open(path, rig, message, message_size);
  if (status != FB_OK) return status;
  copy_declarations(rig);
  if (!*lie) return FB_OK;
  /* what a host cannot read it cannot destroy either */
  LIE("abi") free(rig->user), rig->abi = FB_RIG_ABI + 1;
  LIE("older abi") free(rig->user), rig->abi = FB_RIG_ABI - 1;
  LIE("struct size") free(rig->user), rig->struct_size = 8;
  LIE("control stride") rig->control_stride = offsetof(fb_rig_control, rest);
  LIE("clip stride") rig->clip_stride = 0;
  LIE("longer structs") lengthen(rig);
  LIE("no name") rig->name = NULL;
  LIE("no units") rig->units = "";
  LIE("up axis") rig->up_axis = "x";
  LIE("no evaluate") rig->evaluate = NULL;
  LIE("no controls") rig->control_count = 0;
  LIE("null controls") rig->controls = NULL;
  LIE("no vertices") rig->vertex_count = 0;
  LIE("null rest") rig->rest_positions = NULL;
  LIE("no polygons") rig->polygon_count = 0;
  LIE("null corners") rig->polygon_corners = NULL;
  LIE("null control name") lying_controls[2].name = NULL;
  LIE("double control") lying_controls[2].name = "jawOpen";
  LIE("range") lying_controls[2].maximum = -1;
  LIE("range nan") lying_controls[2].minimum = NAN;
  LIE("default") lying_controls[2].rest = 3;
  LIE("two corners") lying_sizes[5] = 2;
  LIE("huge polygon") lying_sizes[5] = 1000000000u;
  LIE("bad corner") lying_corners[9] = vertices;
  LIE("rest nan") lying_rest[30] = NAN;
  LIE("rest moved") lying_rest[3 * 20] += 0.01f;
  LIE("texture") give_uvs(rig, 3);
  LIE("texture beyond an older struct") give_uvs(rig, 3), rig->struct_size = offsetof(fb_rig, uv_count);
  LIE("null texture") give_uvs(rig, 3), rig->uvs = NULL;
  LIE("texture corner") give_uvs(rig, 2);
  LIE("null clips") rig->clips = NULL;
  LIE("double clip") lying_clips[1].name = "talk";
  LIE("clip kind") lying_clips[1].kind = 5;
  LIE("clip split") lying_clips[1].split = -1;
  LIE("clip fps") lying_clips[1].fps = 0;
  LIE("clip empty") lying_clips[1].frames = 0;
  LIE("clip null") lying_clips[1].controls = NULL;
  LIE("clip range") lying_values[4 * controls + 3] = 1.5f;
  LIE("clip nan") lying_values[4 * controls + 3] = NAN;
  LIE("fails on a pose") rig->evaluate = fail_on_marked;
  LIE("fails without words") rig->evaluate = fail_without_words;
  LIE("fails on blocks") rig->evaluate = fail_on_blocks;
  LIE("nan on a pose") rig->evaluate = nan_on_marked;
  LIE("first pose only") rig->evaluate = first_pose_only;
  LIE("other shape") rig->evaluate = bulge_more;
  LIE("one thread only") rig->flags = 0, rig->evaluate = count_calls;
  else {
    snprintf(message, message_size, "there is no lie called %s", lie);
    return FB_ERROR_INVALID_ARGUMENT;
  }
  return FB_OK;
}
