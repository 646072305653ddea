/* A rig the host describes itself, through sampling and baking to a face that poses. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CONTROLS 2
#define VERTICES 8

static const float cube[3 * VERTICES] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
static const uint32_t sizes[] = {4, 4};
static const uint32_t corners[] = {0, 1, 2, 3, 4, 5, 6, 7};
static const fb_rig_control rig_controls[CONTROLS] = {{"lift", "top", 0, 1, 0, 0}, {"slide", NULL, -1, 1, 0, 0}};

/* lift raises the upper four vertices, slide moves all of them along x. */
static fb_status evaluate(void* user, uint64_t poses, const float* controls, float* positions, char* message,
                          uint32_t message_size) {
  if (*(int*)user) {
    snprintf(message, message_size, "out of clay");
    return FB_ERROR_RIG;
  }
  for (uint64_t p = 0; p < poses; ++p, controls += CONTROLS)
    for (int v = 0; v < VERTICES; ++v, positions += 3) {
      memcpy(positions, cube + 3 * v, 3 * sizeof(float));
      positions[0] += 0.5f * controls[1];
      if (v >= 4) positions[2] += 0.25f * controls[0];
    }
  return FB_OK;
}

static fb_rig describe(int* broken) {
  fb_rig rig;
  fb_rig_init(&rig);
  rig.name = "cube";
  rig.units = "m";
  rig.up_axis = "z";
  rig.flags = FB_RIG_THREAD_SAFE;
  rig.control_count = CONTROLS;
  rig.controls = rig_controls;
  rig.vertex_count = VERTICES;
  rig.polygon_count = 2;
  rig.rest_positions = cube;
  rig.polygon_sizes = sizes;
  rig.polygon_corners = corners;
  rig.user = broken;
  rig.evaluate = evaluate;
  return rig;
}

/* A source of one path or of a rig. */
static fb_status open_source(const char* path, const fb_rig* rig, fb_source** source) {
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = path ? 1 : 0;
  desc.rig = rig;
  return fb_source_open(&desc, source);
}

static char folder[64];

static int make_folder(void** state) {
  (void)state;
  snprintf(folder, sizeof folder, "capi_baking_%ld", (long)getpid());
  char command[128];
  snprintf(command, sizeof command, "mkdir %s", folder);
  return system(command);
}

static int remove_folder(void** state) {
  (void)state;
  char command[128];
  snprintf(command, sizeof command, "rm -rf %s", folder);
  return system(command);
}

static const char* in_folder(const char* name) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

typedef struct Watch {
  int calls, stop;
} Watch;

static int32_t watch(void* user, const char* stage, uint64_t done, uint64_t total) {
  Watch* w = user;
  ++w->calls;
  assert_true(strlen(stage) > 0 && done <= total);
  return w->stop;
}

static void a_rig_becomes_a_face(void** state) {
  (void)state;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  fb_source* source = NULL;
  assert_ok(open_source(NULL, &rig, &source));
  Watch seen = {0, 0};
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  desc.threads = 1;
  desc.source = source;
  desc.archive = in_folder("cube.fbk");
  desc.recipe = "linear";
  desc.poses = 100;
  desc.callbacks.progress = watch;
  desc.callbacks.user = &seen;
  assert_ok(fb_bake(&desc, NULL));
  assert_true(seen.calls > 0);
  fb_source_close(source);

  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  assert_ok(fb_load(in_folder("cube.fbk"), NULL, &model));
  assert_string_equal(fb_name(model), "cube");
  assert_string_equal(fb_up_axis(model), "z");
  assert_ok(fb_scratch_create(model, 1, &scratch));
  const float pose[CONTROLS] = {0.5f, -1};
  float expected[3 * VERTICES], positions[3 * VERTICES];
  assert_ok(evaluate(&broken, 1, pose, expected, NULL, 0));
  assert_ok(fb_evaluate(model, scratch, pose, positions));
  for (int i = 0; i < 3 * VERTICES; ++i) assert_true(fabsf(positions[i] - expected[i]) < 1e-3f);
  fb_scratch_destroy(scratch);
  fb_release(model);
}

static void a_rig_is_sampled_to_a_dataset_that_can_be_baked(void** state) {
  (void)state;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  char directory[128];
  snprintf(directory, sizeof directory, "%s/dataset", folder);
  fb_sample_desc sampling;
  fb_sample_desc_init(&sampling);
  assert_ok(open_source(NULL, &rig, &sampling.source));
  sampling.directory = directory;
  sampling.poses = 100;
  assert_ok(fb_sample(&sampling, NULL));
  fb_source_close(sampling.source);

  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  assert_ok(open_source(directory, NULL, &desc.source));
  desc.archive = in_folder("from_dataset.fbk");
  desc.recipe = "linear";
  assert_ok(fb_bake(&desc, NULL));
  fb_source_close(desc.source);
  fb_model* model = NULL;
  assert_ok(fb_load(in_folder("from_dataset.fbk"), NULL, &model));
  assert_int_equal(fb_vertex_count(model), VERTICES);
  fb_release(model);
}

static void a_host_may_interrupt(void** state) {
  (void)state;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  Watch seen = {0, 1};
  fb_sample_desc desc;
  fb_sample_desc_init(&desc);
  assert_ok(open_source(NULL, &rig, &desc.source));
  desc.directory = in_folder("interrupted");
  desc.poses = 100;
  desc.callbacks.progress = watch;
  desc.callbacks.user = &seen;
  assert_int_equal(fb_sample(&desc, NULL), FB_ERROR_INTERRUPTED);
  fb_source_close(desc.source);
}

static void assert_bake_refused(const fb_bake_desc* desc, fb_status expected, const char* message_part) {
  assert_int_equal(fb_bake(desc, NULL), expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("\"%s\" does not contain \"%s\"", fb_last_error(), message_part);
  assert_int_not_equal(access(desc->archive ? desc->archive : "", F_OK), 0);
}

static void assert_open_refused(const fb_source_desc* desc, fb_status expected, const char* message_part) {
  fb_source* source = NULL;
  assert_int_equal(fb_source_open(desc, &source), expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("\"%s\" does not contain \"%s\"", fb_last_error(), message_part);
  assert_null(source);
}

static void joints_are_of_gltf_files(void** state) {
  (void)state;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  assert_int_equal(desc.joints, FB_JOINTS_AUTO);
  desc.rig = &rig;
  desc.joints = FB_JOINTS_CONTROLS;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "joints are of glTF files, not of a rig");
  desc.joints = 7;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "joints is 7, none of FB_JOINTS_...");
  desc.joints = FB_JOINTS_AUTO;
  desc.skip_broken = 1;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "skip_broken is of glTF files, not of a rig");
  const char *const path = "sample", *const joint = "jaw";
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = 1;
  desc.skip_broken = 2;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "skip_broken is 2");
  desc.skip_broken = 1;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "no source is a glTF file");
  desc.skip_broken = 0;
  desc.control_joint_count = 1;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "fb_source_desc: control_joints");
  desc.control_joints = &joint;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "no source is a glTF file");
}

static void a_rig_without_clips_has_poses_to_measure_on(void** state) {
  (void)state;
  int broken = 0;
  fb_rig rig = describe(&broken);
  rig.clip_count = 0;
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.rig = &rig;
  desc.test_poses = 10;
  fb_source* source = NULL;
  assert_ok(fb_source_open(&desc, &source));
  fb_source_info info;
  fb_source_info_init(&info);
  assert_ok(fb_source_describe(source, &info));
  assert_int_equal(info.clip_count, 3);
  uint64_t frames = 0;
  for (uint32_t c = 0; c < info.clip_count; ++c) {
    fb_clip clip;
    fb_clip_init(&clip);
    assert_ok(fb_source_clip_at(source, c, &clip));
    assert_int_equal(clip.split, FB_SPLIT_TEST);
    frames += clip.frames;
  }
  assert_int_equal(frames, 10);
  fb_source_close(source);
  desc.test_poses = UINT64_C(1) << 40;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "test poses, more than 1048576");
}

/* This program with an argument is a child that serves the host's rig. */
static int serve(void) {
  int broken = 0;
  const fb_rig rig = describe(&broken);
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.rig = &rig;
  return fb_source_serve(&desc, 3, 4);
}

static void a_program_is_a_source(void** state) {
  (void)state;
  char self[512], command[600];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  assert_true(length > 0);
  self[length] = 0;
  snprintf(command, sizeof command, "exec:exec '%s' serve", self);
  const char* const path = command;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = 1;
  desc.workers = 2;
  fb_source *child = NULL, *here = NULL;
  assert_ok(fb_source_open(&desc, &child));
  assert_ok(open_source(NULL, &rig, &here));
  fb_source_info info;
  fb_source_info_init(&info);
  assert_ok(fb_source_describe(child, &info));
  assert_true((info.flags & FB_SOURCE_LIVE) != 0);
  assert_string_equal(info.name, rig.name);
  enum { poses = 3 };
  const size_t floats = (size_t)poses * 3 * info.vertex_count;
  float* controls = calloc((size_t)poses * info.control_count, sizeof(float));
  float *a = malloc(floats * sizeof(float)), *b = malloc(floats * sizeof(float));
  for (uint32_t i = 0; i < poses * info.control_count; ++i) controls[i] = rig.controls[i % info.control_count].maximum;
  assert_ok(fb_source_evaluate(child, controls, poses, 0, a, floats));
  assert_ok(fb_source_evaluate(here, controls, poses, 0, b, floats));
  assert_memory_equal(a, b, floats * sizeof(float));
  free(controls), free(a), free(b);
  fb_source_close(child);
  fb_source_close(here);
}

static void wrong_children_are_refused(void** state) {
  (void)state;
  const char* path = "exec:exit 3";
  fb_source_desc good, desc;
  fb_source_desc_init(&good);
  good.paths = &path;
  good.path_count = 1;
  assert_open_refused(&good, FB_ERROR_RIG, "ended with exit code 3");
  desc = good, desc.workers = 257;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "257 workers");
  desc = good, desc.pose_seconds = 0;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "pose_seconds");
  path = "sample";
  desc = good, desc.workers = 1, desc.host = "/no/such/host";
  assert_open_refused(&desc, FB_ERROR_RIG, "/no/such/host cannot be started");
  assert_int_equal(fb_source_serve(NULL, 3, 4), FB_ERROR_INVALID_ARGUMENT);
}

static void wrong_sources_are_refused(void** state) {
  (void)state;
  int broken = 1;
  const fb_rig rig = describe(&broken);
  const char* const paths[2] = {"nowhere", NULL};
  fb_source_desc good, desc;
  fb_source_desc_init(&good);
  good.rig = &rig;
  assert_open_refused(&good, FB_ERROR_RIG, "out of clay");
  desc = good, desc.paths = paths, desc.path_count = 1;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "either");
  desc = good, desc.rig = NULL;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "either");
  desc.path_count = 1;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "paths");
  desc.paths = paths;
  assert_open_refused(&desc, FB_ERROR_NOT_FOUND, "nowhere");
  desc.path_count = 2;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "paths");
  desc = good, desc.struct_size = 4;
  assert_open_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "struct_size");
  fb_rig older = rig;
  older.abi = FB_RIG_ABI - 1;
  desc = good, desc.rig = &older;
  assert_open_refused(&desc, FB_ERROR_UNSUPPORTED, "rig ABI 1");
  assert_int_equal(fb_source_open(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_source_open(&good, NULL), FB_ERROR_INVALID_ARGUMENT);
  fb_source_desc_init(NULL);
  fb_source_close(NULL);
}

static void wrong_requests_are_refused(void** state) {
  (void)state;
  int broken = 0;
  const fb_rig rig = describe(&broken);
  fb_source* source = NULL;
  assert_ok(open_source(NULL, &rig, &source));
  broken = 1;
  fb_bake_desc good, desc;
  fb_bake_desc_init(&good);
  good.source = source;
  good.archive = in_folder("refused.fbk");
  assert_bake_refused(&good, FB_ERROR_RIG, "out of clay");
  desc = good, desc.source = NULL;
  assert_bake_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "source");
  desc = good, desc.archive = NULL;
  assert_bake_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "archive");
  desc = good, desc.use = 7;
  assert_bake_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "use 7");
  desc = good, desc.struct_size = 4;
  assert_bake_refused(&desc, FB_ERROR_INVALID_ARGUMENT, "struct_size");
  broken = 0;
  desc = good, desc.recipe = "soup";
  assert_bake_refused(&desc, FB_ERROR_NOT_FOUND, "soup");
  assert_int_equal(fb_bake(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_sample(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  fb_sample_desc sampling;
  fb_sample_desc_init(&sampling);
  sampling.source = source;
  assert_int_equal(fb_sample(&sampling, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "directory"));
  fb_sample_desc_init(NULL);
  fb_bake_desc_init(NULL);
  fb_source_close(source);
}

int main(int count, char** arguments) {
  (void)arguments;
  if (count > 1) return serve();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_rig_becomes_a_face),
      cmocka_unit_test(a_rig_is_sampled_to_a_dataset_that_can_be_baked),
      cmocka_unit_test(a_host_may_interrupt),
      cmocka_unit_test(wrong_sources_are_refused),
      cmocka_unit_test(wrong_requests_are_refused),
      cmocka_unit_test(joints_are_of_gltf_files),
      cmocka_unit_test(a_rig_without_clips_has_poses_to_measure_on),
      cmocka_unit_test(a_program_is_a_source),
      cmocka_unit_test(wrong_children_are_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
