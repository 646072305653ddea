/* What the commands eval, inspect, verify, pack, pose and bench of the tool do, through the C interface alone. */
#include "authoring_fixture.h"

#include <sys/stat.h>

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
  assert_int_equal(info.format_version, 2000); /* without what 2.1 adds */
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

static void rights_are_judged_by_a_day(void** state) {
  (void)state;
  const char* about =
      "{\"rights\": {\"expires\": \"2024-02-29\", \"learning\": \"allowed\", \"ai_training\": \"constrained\","
      " \"constraint_info\": \"ask Ada\", \"data_mining\": \"notAllowed\", \"suspendable\": \"yes\"}}";
  fb_report* report = NULL;
  assert_ok(fb_rights(about, "2024-02-29", &report));
  fb_rights_result result;
  fb_rights_result_init(&result);
  assert_ok(fb_report_rights(report, &result));
  assert_true(result.stated == 1 && result.expired == 0 && result.suspendable == 1);
  assert_int_equal(result.learning, FB_PERMISSION_CONSTRAINED);
  assert_int_equal(result.ai_training, FB_PERMISSION_CONSTRAINED);
  assert_int_equal(result.ai_generative_training, FB_PERMISSION_ALLOWED);
  assert_int_equal(result.data_mining, FB_PERMISSION_NOT_ALLOWED);
  assert_string_equal(result.last_day, "2024-02-29");
  assert_string_equal(result.binding,
                      "the rights end on 2024-02-29\n"
                      "learning from it is constrained (ai_training: constrained, ask Ada)\n"
                      "mining it for data is forbidden (data_mining: notAllowed)\n"
                      "the consent can be suspended; where its state is asked is not said\n");
  assert_contains(fb_report_json(report), "\"expired\": false");
  fb_verify_result other;
  fb_verify_result_init(&other);
  assert_refused(fb_report_verify(report, &other), FB_ERROR_INVALID_ARGUMENT, "it has no fb_verify_result");
  fb_report_free(report);
  assert_ok(fb_rights(about, NULL, &report)); /* today, which is later */
  assert_ok(fb_report_rights(report, &result));
  assert_int_equal(result.expired, 1);
  fb_report_free(report);
}

static void rights_may_be_missing_or_anything(void** state) {
  (void)state;
  fb_report* report = NULL;
  fb_rights_result result;
  fb_rights_result_init(&result);
  assert_ok(fb_rights("", NULL, &report));
  assert_ok(fb_report_rights(report, &result));
  assert_true(result.stated == 0 && result.expired == 0 && result.learning == FB_PERMISSION_UNSTATED);
  assert_string_equal(result.last_day, "");
  assert_string_equal(result.binding, "");
  fb_report_free(report);
  assert_ok(fb_rights("nonsense", "2031-12-31", &report));
  assert_ok(fb_report_rights(report, &result));
  assert_true(result.stated == 1 && result.learning == FB_PERMISSION_NOT_ALLOWED);
  fb_report_free(report);
  assert_refused(fb_rights("{}", "2031-02-29", &report), FB_ERROR_INVALID_ARGUMENT, "2031-02-29 is no day");
  assert_refused(fb_rights(NULL, NULL, &report), FB_ERROR_INVALID_ARGUMENT, "about");
  assert_refused(fb_rights("{}", NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "report");
  assert_ok(fb_verify(toy_face, &report));
  assert_refused(fb_report_rights(report, &result), FB_ERROR_INVALID_ARGUMENT, "it has no fb_rights_result");
  fb_report_free(report);
}

static void an_archive_is_compared_with_another(void** state) {
  (void)state;
  fb_report* report = NULL;
  assert_ok(fb_diff(toy_face, toy_face, &report));
  assert_contains(fb_report_json(report), "\"equal\": true");
  fb_report_free(report);
  assert_ok(fb_diff(toy_face, toy_face, NULL));
  assert_int_equal(fb_diff(toy_face, NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
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
  assert_true(result.bytes_before == info.byte_count && result.format == 2000);
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

/* ---- Messages ---- */

static void assert_refused_shortly(fb_status status, fb_status expected, const char* reason) {
  assert_refused(status, expected, reason);
  assert_contains(fb_last_error(), "...");
  assert_true(strlen(fb_last_error()) < 500);
}

static void messages_keep_their_reason_however_long_a_path(void** state) {
  (void)state;
  char deep[3700], inside[3800];
  size_t length = (size_t)snprintf(deep, sizeof deep, "%s", folder);
  while (length < 3400) {
    deep[length++] = '/';
    memset(deep + length, 'd', 200);
    deep[length += 200] = '\0';
    assert_int_equal(mkdir(deep, 0700), 0);
  }
  snprintf(inside, sizeof inside, "%s/none/file", deep);

  fb_pack_desc pack;
  fb_pack_desc_init(&pack);
  pack.path = FB_FIXTURE;
  pack.out = inside;
  assert_refused_shortly(fb_pack(&pack, NULL), FB_ERROR_IO, "cannot be written: No such file");
  pack.out = deep;
  assert_refused_shortly(fb_pack(&pack, NULL), FB_ERROR_IO, "is a directory");
  const char* path = inside;
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = 1;
  fb_source* source = NULL;
  assert_refused_shortly(fb_source_open(&desc, &source), FB_ERROR_NOT_FOUND, "no such file or folder");
  path = deep;
  assert_refused_shortly(fb_source_open(&desc, &source), FB_ERROR_NOT_FOUND, "is no dataset folder");
  uint64_t frames = 0;
  assert_refused_shortly(fb_clip_file_frames(inside, controls, &frames), FB_ERROR_NOT_FOUND, "no such file");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_archive_is_measured_against_its_rig),
      cmocka_unit_test(an_archive_is_inspected),
      cmocka_unit_test(the_networks_of_an_archive_can_be_evaluated),
      cmocka_unit_test(an_archive_is_verified),
      cmocka_unit_test(rights_are_judged_by_a_day),
      cmocka_unit_test(rights_may_be_missing_or_anything),
      cmocka_unit_test(an_archive_is_compared_with_another),
      cmocka_unit_test(an_archive_is_packed_again),
      cmocka_unit_test(a_clip_from_a_file_is_posed),
      cmocka_unit_test(messages_keep_their_reason_however_long_a_path),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
