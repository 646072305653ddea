/* What every command of the tool does, through the C interface alone. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[64];
static const char* const toy_path = FB_TOY_RIG;
static fb_source* toy;       /* the toy rig: 6 controls, 50 vertices, a train and a test shot */
static fb_archive* toy_face; /* a face of it */

enum { controls = 6, vertices = 50, floats = 3 * vertices };

static const char* in_folder(const char* name) {
  static char paths[8][160];
  static unsigned next;
  char* path = paths[next++ % 8];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  return path;
}

static int run(const char* command, const char* path) {
  char line[256];
  snprintf(line, sizeof line, "%s %s", command, path);
  return system(line);
}

static void assert_contains(const char* text, const char* part) {
  if (!strstr(text, part)) fail_msg("there is no %s in %.300s", part, text);
}

static void assert_refused(fb_status status, fb_status expected, const char* message_part) {
  if (status != expected) fail_msg("%s (%s), not %s", fb_status_name(status), fb_last_error(), message_part);
  assert_contains(fb_last_error(), message_part);
}

/* What a host sees of a call. */
typedef struct Seen {
  int stages, calls, notes;
  int stop_after; /* calls; 0: never */
  char note[512];
} Seen;

static int32_t see_progress(void* user, const char* stage, uint64_t done, uint64_t total) {
  Seen* seen = user;
  assert_true(*stage && done <= total);
  seen->stages += done == 0;
  ++seen->calls;
  return seen->stop_after > 0 && seen->calls >= seen->stop_after;
}

static void see_note(void* user, const char* sentence) {
  Seen* seen = user;
  ++seen->notes;
  snprintf(seen->note, sizeof seen->note, "%s", sentence);
}

static fb_callbacks watch(Seen* seen) {
  memset(seen, 0, sizeof *seen);
  const fb_callbacks callbacks = {seen, see_progress, see_note};
  return callbacks;
}

static fb_source* open_paths(const char* const* paths, uint32_t count, Seen* seen) {
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = paths;
  desc.path_count = count;
  desc.callbacks = watch(seen);
  fb_source* source = NULL;
  assert_ok(fb_source_open(&desc, &source));
  return source;
}

static fb_source_info describe(const fb_source* source) {
  fb_source_info info;
  fb_source_info_init(&info);
  assert_ok(fb_source_describe(source, &info));
  return info;
}

static int set_up(void** state) {
  (void)state;
  Seen seen;
  snprintf(folder, sizeof folder, "capi_commands_%ld", (long)getpid());
  if (run("mkdir", folder) != 0) return 1;
  toy = open_paths(&toy_path, 1, &seen);
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  desc.source = toy;
  desc.archive = in_folder("toy.fbk");
  desc.recipe = "linear";
  desc.poses = 200;
  desc.threads = 2;
  assert_ok(fb_bake(&desc, NULL));
  assert_ok(fb_archive_open(desc.archive, &toy_face));
  return 0;
}

static int tear_down(void** state) {
  (void)state;
  fb_archive_close(toy_face);
  fb_source_close(toy);
  return run("rm -rf", folder);
}

/* ---- Sources ---- */

static void a_source_tells_what_it_is(void** state) {
  (void)state;
  const fb_source_info info = describe(toy);
  assert_string_equal(info.name, "toy");
  assert_string_equal(info.units, "cm");
  assert_string_equal(info.up_axis, "y");
  assert_int_equal(info.flags, FB_SOURCE_LIVE | FB_RIG_THREAD_SAFE);
  assert_int_equal(info.control_count, controls);
  assert_int_equal(info.vertex_count, vertices);
  assert_int_equal(info.polygon_count, 37);
  assert_int_equal(info.polygon_corner_count, 4 * 36 + 3);
  assert_int_equal(info.polygon_sizes[36], 3);
  assert_true(info.diagonal > 10 && info.rest_positions && info.uv_count == 0 && !info.uvs && !info.uv_corners);

  fb_control control;
  fb_control_init(&control);
  assert_ok(fb_source_control_at(toy, 1, &control));
  assert_string_equal(control.name, "browTwist");
  assert_string_equal(control.group, "brow");
  assert_true(control.minimum == -1 && control.maximum == 1 && control.rest == 0);
  assert_refused(fb_source_control_at(toy, controls, &control), FB_ERROR_INVALID_ARGUMENT, "control 6 of 6");

  fb_clip clip;
  fb_clip_init(&clip);
  assert_ok(fb_source_clip_at(toy, 1, &clip));
  assert_string_equal(clip.name, "frown");
  assert_true(clip.kind == FB_CLIP_SHOT && clip.split == FB_SPLIT_TEST && clip.readable == 1 && clip.fps == 24);
  assert_true(clip.frames == 12 && clip.controls);
  assert_refused(fb_source_clip_at(toy, 2, &clip), FB_ERROR_INVALID_ARGUMENT, "clip 2 of 2");
  assert_int_equal(fb_source_describe(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
}

static void frames_of_a_clip_are_its_controls_evaluated(void** state) {
  (void)state;
  fb_clip clip;
  fb_clip_init(&clip);
  assert_ok(fb_source_clip_at(toy, 0, &clip));
  float read[3 * floats], evaluated[3 * floats];
  assert_ok(fb_source_read(toy, 0, 4, 3, read, 3 * floats));
  assert_ok(fb_source_evaluate(toy, clip.controls + 4 * controls, 3, 2, evaluated, 3 * floats));
  assert_memory_equal(read, evaluated, sizeof read);
  assert_refused(fb_source_read(toy, 0, 10, 3, read, 3 * floats), FB_ERROR_INVALID_ARGUMENT, "\"talk\" has 12 frames");
  assert_refused(fb_source_read(toy, 0, 0, 3, read, 2 * floats), FB_ERROR_INVALID_ARGUMENT, "3 poses need 450");
  assert_refused(fb_source_read(toy, 7, 0, 1, read, floats), FB_ERROR_INVALID_ARGUMENT, "clip 7");
  assert_refused(fb_source_evaluate(toy, clip.controls, 3, 1, evaluated, floats), FB_ERROR_INVALID_ARGUMENT,
                 "3 poses need 450");
  assert_refused(fb_source_evaluate(toy, clip.controls, 1, 5000, evaluated, floats), FB_ERROR_INVALID_ARGUMENT,
                 "5000 threads");
  const float beyond[controls] = {2, 0, 0, 0, 0, 0};
  assert_refused(fb_source_evaluate(toy, beyond, 1, 1, evaluated, floats), FB_ERROR_INVALID_ARGUMENT, "\"browRaise\"");
  assert_int_equal(fb_source_evaluate(toy, NULL, 1, 1, evaluated, floats), FB_ERROR_INVALID_ARGUMENT);
}

static void opening_gives_notes(void** state) {
  (void)state;
  const char* const twice[2] = {toy_path, toy_path};
  Seen seen;
  fb_source* source = open_paths(twice, 2, &seen);
  assert_int_equal(seen.notes, 2);
  assert_contains(seen.note, "\"frown\" is there already");
  assert_int_equal(describe(source).clip_count, 2);
  fb_source_close(source);
}

/* ---- sample ---- */

static void sampling_writes_a_dataset(void** state) {
  (void)state;
  float extra[2 * controls] = {0};
  extra[3] = 0.75f, extra[controls + 3] = 1.5f;
  const fb_rig_clip clip = {"smile", FB_CLIP_SHOT, FB_SPLIT_VALIDATION, 25, 2, 0, extra};
  Seen seen;
  fb_sample_desc desc;
  fb_sample_desc_init(&desc);
  desc.source = toy;
  desc.directory = in_folder("dataset");
  desc.poses = 60;
  desc.mix = "paper";
  desc.clips = &clip;
  desc.clip_count = 1;
  desc.callbacks = watch(&seen);
  fb_report* report = NULL;
  assert_ok(fb_sample(&desc, &report));
  assert_true(seen.stages > 0 && seen.calls > seen.stages);
  assert_contains(seen.note, "clip \"smile\": 1 values outside their range were clamped");
  fb_sample_result result;
  fb_sample_result_init(&result);
  assert_ok(fb_report_sample(report, &result));
  assert_true(result.poses >= 60 + 24 + 2 && result.evaluated == result.poses && result.rig_calls > result.poses);
  assert_contains(fb_report_json(report), "\"rig_calls\": ");
  assert_contains(fb_report_json(report), "/dataset\"");
  fb_verify_result other;
  fb_verify_result_init(&other);
  assert_refused(fb_report_verify(report, &other), FB_ERROR_INVALID_ARGUMENT, "another call");
  const char* details = NULL;
  assert_refused(fb_report_details(report, &details), FB_ERROR_INVALID_ARGUMENT, "details");
  fb_report_free(report);

  fb_source* recording = open_paths(&desc.directory, 1, &seen);
  const fb_source_info info = describe(recording);
  assert_int_equal(info.flags, FB_RIG_THREAD_SAFE);
  for (uint32_t c = 0; c < info.clip_count; ++c) {
    fb_clip read;
    fb_clip_init(&read);
    assert_ok(fb_source_clip_at(recording, c, &read));
    if (strcmp(read.name, "smile") != 0) continue;
    assert_true(read.frames == 2 && read.split == FB_SPLIT_VALIDATION && read.fps == 25);
    assert_true(read.controls[3] == 0.75f && read.controls[controls + 3] == 1);
    float recorded[floats], evaluated[floats];
    assert_ok(fb_source_read(recording, c, 1, 1, recorded, floats));
    assert_ok(fb_source_evaluate(toy, read.controls + controls, 1, 1, evaluated, floats));
    assert_memory_equal(recorded, evaluated, sizeof recorded);
  }
  desc.source = recording;
  assert_refused(fb_sample(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "is a recording");
  fb_source_close(recording);

  desc.source = toy;
  desc.directory = in_folder("within");
  desc.clip_count = 0;
  desc.rig_budget = 160;
  assert_ok(fb_sample(&desc, &report));
  assert_ok(fb_report_sample(report, &result));
  assert_true(result.poses > 0 && result.rig_calls <= 160);
  fb_report_free(report);

  desc.rig_budget = 3;
  desc.directory = in_folder("poor");
  assert_int_equal(fb_sample(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
  desc.clips = &clip, desc.clip_count = 1, desc.clip_stride = 8;
  assert_refused(fb_sample(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "clip_stride");
}

/* ---- bake ---- */

static void recipes_have_names(void** state) {
  (void)state;
  int heroes = 0;
  assert_true(fb_recipe_count() >= 3);
  for (uint32_t r = 0; r < fb_recipe_count(); ++r) heroes += strcmp(fb_recipe_name(r), "hero") == 0;
  assert_int_equal(heroes, 1);
  assert_null(fb_recipe_name(fb_recipe_count()));
}

static fb_bake_desc small_bake(const char* name) {
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  desc.source = toy;
  desc.archive = in_folder(name);
  desc.poses = 200;
  desc.epochs = 2;
  return desc;
}

static void a_bake_is_measured_for_its_report(void** state) {
  (void)state;
  Seen seen;
  fb_bake_desc desc = small_bake("compact.fbk");
  desc.recipe = "compact";
  desc.use = FB_USE_VARIANT;
  desc.mix = "paper";
  desc.licence = "for tests";
  desc.created = "2020-07-19";
  desc.work = in_folder("compact.work");
  desc.learning_curve = 1;
  desc.measure = FB_MEASURE_QUALITY | FB_MEASURE_LOCALITY;
  desc.callbacks = watch(&seen);
  fb_report* report = NULL;
  assert_ok(fb_bake(&desc, &report));
  assert_true(seen.stages > 3);
  assert_int_equal(access(in_folder("compact.work"), F_OK), 0);

  assert_int_equal(fb_report_method_count(report), 1);
  fb_method face;
  fb_method_init(&face);
  assert_ok(fb_report_method_at(report, 0, &face));
  assert_string_equal(face.name, "compact");
  assert_int_equal(face.use, FB_USE_VARIANT);
  assert_true(face.poses >= 100 && face.coefficients > 0 && face.train_seconds > 0);
  assert_true(face.unseen.frames == 12 && face.unseen.mse > 0 && face.quantisation.frames > 0 && face.clip_count == 1);
  assert_null(fb_report_source(report));
  assert_int_equal(fb_report_failure_count(report), 0);

  fb_archive* archive = NULL;
  assert_ok(fb_archive_open(desc.archive, &archive));
  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(archive, &info));
  assert_int_equal(info.byte_count, face.archive_bytes);
  assert_memory_equal(info.bytes, face.archive, face.archive_bytes);
  assert_string_equal(info.recipe, "compact");
  assert_string_equal(info.licence, "for tests");
  assert_contains(info.provenance, "2020-07-19");
  assert_contains(info.certificate, "\"independent\"");
  fb_archive_close(archive);

  assert_contains(fb_report_json(report), "\"train_seconds\": ");
  const char *details = NULL, *again = NULL;
  assert_ok(fb_report_details(report, &details));
  const char* const keys[] = {"\"measured_split\": \"test\"",
                              "\"frame_mse\"",
                              "\"vertex_rms\"",
                              "\"vertex_region\"",
                              "\"worst_frames\"",
                              "\"learning\"",
                              "\"stages\"",
                              "\"share_above\"",

                              "\"coverage\"",
                              "\"kinds\"",
                              "\"region_names\""};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) assert_contains(details, keys[k]);
  assert_ok(fb_report_details(report, &again));
  assert_ptr_equal(details, again);
  fb_report_free(report);
  fb_report_free(NULL);
}

static void a_bake_may_be_stopped_and_goes_on(void** state) {
  (void)state;
  Seen seen;
  fb_bake_desc desc = small_bake("stopped.fbk");
  desc.recipe = "linear";
  desc.callbacks = watch(&seen);
  seen.stop_after = 6;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INTERRUPTED, "what is done so far is kept");
  assert_int_not_equal(access(desc.archive, F_OK), 0);
  assert_int_equal(access(in_folder("stopped.fbk.work"), F_OK), 0);
  seen.stop_after = 0;
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(access(desc.archive, F_OK), 0);
  assert_int_not_equal(access(in_folder("stopped.fbk.work"), F_OK), 0);
}

static void bakes_that_cannot_be_are_refused(void** state) {
  (void)state;
  fb_bake_desc good = small_bake("refused.fbk"), desc;
  good.recipe = "linear";
  desc = good, desc.recipe = "soup";
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_NOT_FOUND, "\"soup\"; there are ");
  desc = good, desc.mix = "cake";
  assert_int_not_equal(fb_bake(&desc, NULL), FB_OK);
  assert_contains(fb_last_error(), "cake");
  desc = good, desc.rig_budget = 2;
  assert_int_equal(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
  desc = good, desc.recipe = "kanyuk2018", desc.max_bytes = 1000;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "kanyuk2018");
  desc = good, desc.archive = in_folder("nowhere/face.fbk");
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_IO, "nowhere");
  desc = good, desc.recipe = NULL;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "recipe");
  desc = good, desc.threads = 5000;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "threads");
  assert_int_not_equal(access(good.archive, F_OK), 0);
}

/* ---- compare ---- */

static void methods_are_compared_on_the_same_poses(void** state) {
  (void)state;
  const char* const methods[2] = {"linear", "kanyuk2018"};
  Seen seen;
  fb_compare_desc desc;
  fb_compare_desc_init(&desc);
  desc.source = toy;
  desc.methods = methods;
  desc.method_count = 2;
  desc.poses = 200;
  desc.callbacks = watch(&seen);
  fb_report* report = NULL;
  assert_ok(fb_compare(&desc, &report));
  assert_int_equal(fb_report_method_count(report), 4); /* each as variant and as backlot */
  fb_source* recorded = fb_report_source(report);
  assert_non_null(recorded);
  for (uint32_t m = 0; m < 4; ++m) {
    fb_method method;
    fb_method_init(&method);
    assert_ok(fb_report_method_at(report, m, &method));
    assert_true(method.unseen.frames > 0 && method.dependency.frames > 0 && method.clip_count > 0);
    fb_clip_errors clip;
    fb_clip_errors_init(&clip);
    assert_ok(fb_report_clip_at(report, m, 0, &clip));
    assert_int_equal(clip.split, FB_SPLIT_TEST);
    fb_model* model = NULL;
    assert_ok(fb_load_memory(method.archive, (size_t)method.archive_bytes, NULL, &model));
    assert_ok(fb_source_check_model(recorded, model));
    fb_release(model);
  }
  fb_method method;
  fb_method_init(&method);
  assert_refused(fb_report_method_at(report, 4, &method), FB_ERROR_INVALID_ARGUMENT, "method 4 of 4");
  float frame[floats];
  assert_ok(fb_source_read(recorded, 0, 0, 1, frame, floats));
  assert_contains(fb_report_json(report), "\"name\": \"kanyuk2018\"");
  assert_contains(fb_report_json(report), "\"failed\": []");
  const char* details = NULL;
  assert_ok(fb_report_details(report, &details));
  assert_contains(details, "\"vertex_rms\"");
  fb_report_free(report);

  const char* const unknown[1] = {"soup"};
  desc.methods = unknown, desc.method_count = 1;
  assert_refused(fb_compare(&desc, &report), FB_ERROR_NOT_FOUND, "soup");
  desc.method_count = 0;
  assert_refused(fb_compare(&desc, &report), FB_ERROR_INVALID_ARGUMENT, "no method");
  desc.methods = methods, desc.method_count = 2, seen.stop_after = 1;
  assert_int_equal(fb_compare(&desc, &report), FB_ERROR_INTERRUPTED);
  assert_int_equal(fb_compare(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
}

/* ---- eval ---- */

static void an_archive_is_measured_against_its_rig(void** state) {
  (void)state;
  Seen seen;
  fb_eval_desc desc;
  fb_eval_desc_init(&desc);
  assert_int_equal(desc.split, FB_SPLIT_TEST);
  desc.archive = toy_face;
  desc.source = toy;
  desc.callbacks = watch(&seen);
  fb_report* report = NULL;
  assert_ok(fb_eval(&desc, &report));
  fb_method face;
  fb_method_init(&face);
  assert_ok(fb_report_method_at(report, 0, &face));
  assert_string_equal(face.name, "toy");
  assert_true(face.unseen.frames == 12 && face.unseen.max > face.unseen.rms && face.clip_count == 1);
  fb_clip_errors clip;
  fb_clip_errors_init(&clip);
  assert_ok(fb_report_clip_at(report, 0, 0, &clip));
  assert_string_equal(clip.name, "frown");
  assert_true(clip.kind == FB_CLIP_SHOT && clip.errors.mse == face.unseen.mse);
  assert_refused(fb_report_clip_at(report, 0, 1, &clip), FB_ERROR_INVALID_ARGUMENT, "clip 1 of 1");
  assert_contains(fb_report_json(report), "\"quality\": null");
  assert_contains(fb_report_json(report), "\"touched_bytes\"");
  fb_report_free(report);

  desc.split = FB_SPLIT_ALL;
  desc.measure = FB_MEASURE_QUALITY | FB_MEASURE_LOCALITY;
  assert_ok(fb_eval(&desc, &report));
  assert_ok(fb_report_method_at(report, 0, &face));
  assert_int_equal(face.unseen.frames, 24);
  assert_contains(fb_report_json(report), "\"normal_degrees_rms\"");
  assert_contains(fb_report_json(report), "\"share_above\"");
  fb_report_free(report);

  desc.split = FB_SPLIT_VALIDATION;
  assert_refused(fb_eval(&desc, &report), FB_ERROR_BAD_DATA, "split validation");
  desc.split = 3;
  assert_refused(fb_eval(&desc, &report), FB_ERROR_INVALID_ARGUMENT, "split 3");
  desc.split = FB_SPLIT_TEST, desc.source = NULL;
  assert_refused(fb_eval(&desc, &report), FB_ERROR_INVALID_ARGUMENT, "source");
  desc.source = toy, desc.archive = NULL;
  assert_refused(fb_eval(&desc, &report), FB_ERROR_INVALID_ARGUMENT, "archive");
  fb_archive* tiny = NULL;
  assert_ok(fb_archive_open(FB_FIXTURE, &tiny));
  desc.archive = tiny;
  assert_refused(fb_eval(&desc, &report), FB_ERROR_BAD_DATA, "controls");
  fb_archive_close(tiny);
}

/* ---- inspect, verify ---- */

static void an_archive_is_inspected(void** state) {
  (void)state;
  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(toy_face, &info));
  assert_int_equal(info.format_version, fb_format_version());
  assert_string_equal(info.name, "toy");
  assert_string_equal(info.recipe, "linear");
  assert_string_equal(info.licence, "");
  assert_contains(info.certificate_summary, "\n");
  assert_true(info.vertex_count == vertices && info.control_count == controls && info.proof_poses > 0);
  uint64_t stored = 0;
  for (uint32_t s = 0; s < info.section_count; ++s) {
    fb_section section;
    fb_section_init(&section);
    assert_ok(fb_archive_section_at(toy_face, s, &section));
    assert_true(*section.name && section.stored_bytes > 0);
    stored += section.stored_bytes;
  }
  assert_true(stored > 0 && stored < info.byte_count);
  assert_null(fb_archive_note_at(toy_face, info.note_count));
  fb_section section;
  fb_section_init(&section);
  assert_refused(fb_archive_section_at(toy_face, 99, &section), FB_ERROR_INVALID_ARGUMENT, "section 99");

  fb_report* report = NULL;
  assert_ok(fb_inspect(toy_face, &report));
  const char* const keys[] = {"\"vertices\": 50",  "\"controls\": 6", "\"recipe\": \"linear\"", "\"bytes\"",
                              "\"runtime_bytes\"", "\"certificate\"", "\"provenance\""};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) assert_contains(fb_report_json(report), keys[k]);
  fb_report_free(report);
  assert_int_equal(fb_inspect(NULL, &report), FB_ERROR_INVALID_ARGUMENT);

  fb_archive* wrong = NULL;
  assert_refused(fb_archive_open("nowhere.fbk", &wrong), FB_ERROR_NOT_FOUND, "nowhere.fbk");
  assert_refused(fb_archive_open(FB_TEXT_FILE, &wrong), FB_ERROR_NOT_AN_ARCHIVE, "CMakeLists.txt");
  assert_int_equal(fb_archive_open_memory("FB", 2, NULL, &wrong), FB_ERROR_NOT_AN_ARCHIVE);
  fb_archive_close(NULL);
}

/* Evaluates a network in floats, less what it gives at rest, as fb_region says. */
static void run_region(const fb_archive* archive, uint32_t index, const float* features, float* out, uint32_t* count) {
  fb_region region;
  fb_region_init(&region);
  assert_ok(fb_archive_region_at(archive, index, &region));
  float x[64], y[64], weights[64 * 64], bias[64];
  for (uint32_t i = 0; i < region.input_count; ++i) x[i] = features[region.inputs[i]];
  for (uint32_t l = 0; l < region.layer_count; ++l) {
    fb_layer layer;
    fb_layer_init(&layer);
    assert_ok(fb_archive_layer_at(archive, index, l, &layer));
    assert_true(layer.inputs <= 64 && layer.outputs <= 64 && (layer.bits == 8 || layer.bits == 16));
    assert_ok(fb_archive_layer_values(archive, index, l, weights, bias));
    for (uint32_t o = 0; o < layer.outputs; ++o) {
      float sum = bias[o];
      for (uint32_t i = 0; i < layer.inputs; ++i) sum += weights[o * layer.inputs + i] * x[i];
      if (layer.activation == FB_ACTIVATION_RELU) sum = sum > 0 ? sum : 0;
      if (layer.activation == FB_ACTIVATION_TANH) sum = tanhf(sum);
      if (layer.activation == FB_ACTIVATION_SILU) sum = sum / (1 + expf(-sum));
      y[o] = sum + (layer.skip ? x[o] : 0);
    }
    memcpy(x, y, layer.outputs * sizeof *x);
    *count = layer.outputs;
  }
  memcpy(out, x, *count * sizeof *out);
}

static void the_networks_of_an_archive_can_be_evaluated(void** state) {
  (void)state;
  fb_archive* tiny = NULL;
  assert_ok(fb_archive_open(FB_FIXTURE, &tiny));
  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(tiny, &info));
  fb_model* model = NULL;
  assert_ok(fb_load_memory(info.bytes, (size_t)info.byte_count, NULL, &model));
  float pose[16], features[32], resting[32], expected[16], coefficients[16];
  assert_true(info.control_count <= 16 && info.feature_count <= 32 && info.coefficient_count <= 16);
  for (uint32_t c = 0; c < info.control_count; ++c) {
    fb_control control;
    fb_control_init(&control);
    assert_ok(fb_control_at(model, c, &control));
    pose[c] = control.minimum + 0.8f * (control.maximum - control.minimum);
  }
  assert_ok(fb_archive_features(tiny, pose, features));
  assert_ok(fb_archive_features(tiny, fb_rest_controls(model), resting));
  uint32_t at = 0;
  for (; at < info.direct_count; ++at) expected[at] = features[fb_archive_direct(tiny)[at]];
  for (uint32_t r = 0; r < info.region_count; ++r) {
    float posed[64], rest[64];
    uint32_t count = 0;
    run_region(tiny, r, features, posed, &count);
    run_region(tiny, r, resting, rest, &count);
    for (uint32_t i = 0; i < count; ++i) expected[at++] = posed[i] - rest[i];
  }
  assert_int_equal(at, info.coefficient_count);
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 1, &scratch));
  assert_ok(fb_evaluate_coefficients(model, scratch, pose, coefficients));
  for (uint32_t i = 0; i < at; ++i)
    if (fabsf(coefficients[i] - expected[i]) > 0.05f * (1 + fabsf(expected[i])))
      fail_msg("coefficient %u is %g, not %g", i, (double)coefficients[i], (double)expected[i]);
  fb_scratch_destroy(scratch);
  fb_release(model);

  fb_region region;
  fb_region_init(&region);
  assert_refused(fb_archive_region_at(tiny, 9, &region), FB_ERROR_INVALID_ARGUMENT, "region 9");
  fb_layer layer;
  fb_layer_init(&layer);
  assert_refused(fb_archive_layer_at(tiny, 0, 9, &layer), FB_ERROR_INVALID_ARGUMENT, "layer 9");
  fb_archive_close(tiny);
}

static void an_archive_is_verified(void** state) {
  (void)state;
  fb_report* report = NULL;
  assert_ok(fb_verify(toy_face, &report));
  fb_verify_result result;
  fb_verify_result_init(&result);
  assert_ok(fb_report_verify(report, &result));
  assert_true(result.poses > 0 && result.vertices == vertices && result.bytes > 0);
  assert_contains(fb_report_json(report), "\"vertices\": 50");
  assert_contains(fb_report_json(report), "\"certificate\": {");
  fb_report_free(report);
  assert_ok(fb_verify(toy_face, NULL));
  assert_int_equal(fb_verify(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
}

/* ---- pack ---- */

static void an_archive_is_packed_again(void** state) {
  (void)state;
  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(toy_face, &info));
  fb_pack_desc desc;
  fb_pack_desc_init(&desc);
  desc.bytes = info.bytes;
  desc.byte_count = info.byte_count;
  desc.out = in_folder("packed.fbk");
  desc.licence = "anew";
  fb_report* report = NULL;
  assert_ok(fb_pack(&desc, &report));
  fb_pack_result result;
  fb_pack_result_init(&result);
  assert_ok(fb_report_pack(report, &result));
  assert_true(result.within_limits && result.step_factor == 1 && result.displacement.frames == 0);
  assert_true(result.bytes_before == info.byte_count && result.format == fb_format_version());
  fb_archive* packed = NULL;
  assert_ok(fb_archive_open(desc.out, &packed));
  fb_archive_info new_info;
  fb_archive_info_init(&new_info);
  assert_ok(fb_archive_describe(packed, &new_info));
  assert_string_equal(new_info.licence, "anew");
  assert_memory_equal(new_info.bytes, result.archive, result.archive_bytes);
  fb_archive_close(packed);
  fb_report_free(report);

  desc.out = NULL;
  desc.max_error = 1e-2;
  assert_ok(fb_pack(&desc, &report));
  assert_ok(fb_report_pack(report, &result));
  assert_true(result.step_factor > 1 && result.displacement.max <= 1e-2 && result.archive_bytes < info.byte_count);
  assert_contains(fb_report_json(report), "\"step_factor\": ");
  fb_report_free(report);

  desc.max_error = 0;
  desc.max_bytes = 100;
  assert_refused(fb_pack(&desc, &report), FB_ERROR_LIMIT, "100 bytes cannot be had");
  desc.force = 1;
  assert_ok(fb_pack(&desc, &report));
  assert_ok(fb_report_pack(report, &result));
  assert_int_equal(result.within_limits, 0);
  fb_report_free(report);

  desc.path = "nowhere.fbk";
  assert_refused(fb_pack(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "either");
  desc.bytes = NULL;
  assert_refused(fb_pack(&desc, NULL), FB_ERROR_NOT_FOUND, "nowhere.fbk");
  desc.path = NULL;
  assert_refused(fb_pack(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "either");
}

/* ---- pose, bench ---- */

static void write_npy(const char* path, const float* values, unsigned rows, unsigned columns) {
  char header[128];
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  const int length =
      snprintf(header, sizeof header, "{'descr': '<f4', 'fortran_order': False, 'shape': (%u, %u), }", rows, columns);
  assert_true(length < 117);
  memset(header + length, ' ', 118 - (size_t)length);
  header[117] = '\n';
  assert_int_equal(fwrite("\x93NUMPY\x01\x00\x76\x00", 1, 10, file), 10);
  assert_int_equal(fwrite(header, 1, 118, file), 118);
  assert_int_equal(fwrite(values, sizeof *values * columns, rows, file), rows);
  fclose(file);
}

static void a_clip_from_a_file_is_posed(void** state) {
  (void)state;
  float clip[3 * controls];
  for (int i = 0; i < 3 * controls; ++i) clip[i] = 0.05f * (float)i;
  const char* path = in_folder("clip.npy");
  write_npy(path, clip, 3, controls);
  uint64_t frames = 0;
  assert_ok(fb_clip_file_frames(path, controls, &frames));
  assert_int_equal(frames, 3);
  float read[2 * controls];
  assert_ok(fb_clip_file_read(path, controls, 1, 2, read));
  assert_memory_equal(read, clip + controls, sizeof read);
  assert_refused(fb_clip_file_read(path, controls, 2, 2, read), FB_ERROR_INVALID_ARGUMENT, "has 3 frames");
  assert_refused(fb_clip_file_frames(path, 5, &frames), FB_ERROR_BAD_DATA, "shape (3, 6) is not frames x 5");
  assert_refused(fb_clip_file_frames("nowhere.npy", 5, &frames), FB_ERROR_NOT_FOUND, "nowhere.npy");

  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(toy_face, &info));
  fb_model* model = NULL;
  assert_ok(fb_load_memory(info.bytes, (size_t)info.byte_count, NULL, &model));
  assert_ok(fb_source_check_model(toy, model));
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 1, &scratch));
  float posed[floats], truth[floats];
  assert_ok(fb_evaluate(model, scratch, read, posed));
  assert_ok(fb_source_evaluate(toy, read, 1, 1, truth, floats));
  for (int i = 0; i < floats; ++i) assert_true(fabsf(posed[i] - truth[i]) < 0.2f * (float)info.control_count);
  fb_scratch_destroy(scratch);
  fb_release(model);

  uint64_t bytes[3] = {0}, at_rest = 0;
  assert_ok(fb_archive_pose_bytes(toy_face, clip, 3, bytes));
  float rest[controls] = {0, 0, 0.5f, 0, 0, 0};
  assert_ok(fb_archive_pose_bytes(toy_face, rest, 1, &at_rest));
  assert_true(at_rest > 12 * vertices && bytes[1] > at_rest);
  assert_int_equal(fb_archive_pose_bytes(toy_face, NULL, 1, bytes), FB_ERROR_INVALID_ARGUMENT);

  fb_model* tiny = load_tiny();
  assert_refused(fb_source_check_model(toy, tiny), FB_ERROR_BAD_DATA, "controls");
  fb_release(tiny);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_source_tells_what_it_is),
      cmocka_unit_test(frames_of_a_clip_are_its_controls_evaluated),
      cmocka_unit_test(opening_gives_notes),
      cmocka_unit_test(sampling_writes_a_dataset),
      cmocka_unit_test(recipes_have_names),
      cmocka_unit_test(a_bake_is_measured_for_its_report),
      cmocka_unit_test(a_bake_may_be_stopped_and_goes_on),
      cmocka_unit_test(bakes_that_cannot_be_are_refused),
      cmocka_unit_test(methods_are_compared_on_the_same_poses),
      cmocka_unit_test(an_archive_is_measured_against_its_rig),
      cmocka_unit_test(an_archive_is_inspected),
      cmocka_unit_test(the_networks_of_an_archive_can_be_evaluated),
      cmocka_unit_test(an_archive_is_verified),
      cmocka_unit_test(an_archive_is_packed_again),
      cmocka_unit_test(a_clip_from_a_file_is_posed),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
