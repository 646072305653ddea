/* What the commands sample, bake and compare of the tool do, through the C interface alone. */
#include "authoring_fixture.h"

static void descriptions_have_defaults(void** state) {
  (void)state;
  fb_sample_desc sampling;
  fb_sample_desc_init(&sampling);
  assert_true(sampling.poses == 0 && sampling.seed == 1 && sampling.shots == 1 && sampling.rig_budget == 0);
  assert_true(sampling.clip_count == 0 && sampling.clip_stride == sizeof(fb_rig_clip) && !sampling.callbacks.progress);
  assert_string_equal(sampling.mix, "dense");
  fb_bake_desc bake;
  fb_bake_desc_init(&bake);
  assert_true(bake.poses == 0 && bake.seed == 1 && bake.use == FB_USE_BACKLOT && bake.force == 0 && !bake.work);
  assert_string_equal(bake.recipe, "hero");
  assert_string_equal(bake.mix, "dense");
  fb_compare_desc comparison;
  fb_compare_desc_init(&comparison);
  assert_true(comparison.poses == 0 && comparison.seed == 1 && !comparison.methods && !comparison.work);
  fb_eval_desc measuring;
  fb_eval_desc_init(&measuring);
  assert_true(measuring.split == FB_SPLIT_TEST && measuring.measure == 0);
  fb_pack_desc packing;
  fb_pack_desc_init(&packing);
  assert_true(packing.seed == 1 && packing.max_bytes == 0 && packing.max_error == 0 && packing.force == 0);
  fb_compare_desc_init(NULL);
  fb_eval_desc_init(NULL);
  fb_pack_desc_init(NULL);
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
  assert_true(result.poses > 0 && result.asked <= 160 && result.asked >= 60);
  fb_report_free(report);

  desc.rig_budget = 3;
  desc.directory = in_folder("poor");
  assert_int_equal(fb_sample(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
  desc.clips = &clip, desc.clip_count = 1, desc.clip_stride = 8;
  assert_refused(fb_sample(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "clip_stride");
}

/* ---- plan and check ---- */

static void plans_wait_for_points(void** state) {
  (void)state;
  Seen seen;
  fb_sample_desc desc;
  fb_sample_desc_init(&desc);
  assert_null(desc.schema);
  desc.source = toy;
  desc.directory = in_folder("plan");
  desc.poses = 50;
  desc.callbacks = watch(&seen);
  fb_report* report = NULL;
  assert_ok(fb_plan(&desc, &report));
  assert_contains(fb_report_json(report), "\"rest\": true");
  fb_sample_result planned;
  fb_sample_result_init(&planned);
  assert_ok(fb_report_sample(report, &planned));
  assert_true(planned.poses > 50 && planned.evaluated == 0);
  fb_report_free(report);
  assert_ok(fb_plan(&desc, NULL)); /* the same plan stays */
  desc.seed = 2;
  assert_refused(fb_plan(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "holds another dataset");
  desc.schema = in_folder("plan/dataset.json");
  assert_refused(fb_plan(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "either a source or a schema");
  desc.source = NULL;
  desc.directory = in_folder("from_schema");
  assert_ok(fb_plan(&desc, NULL));
  desc.schema = NULL;
  assert_refused(fb_plan(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "source");

  fb_check_desc check;
  fb_check_desc_init(&check);
  assert_refused(fb_check(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "directory");
  check.directory = in_folder("plan");
  check.callbacks = watch(&seen);
  assert_ok(fb_check(&check, &report));
  fb_check_result found;
  fb_check_result_init(&found);
  assert_ok(fb_report_check(report, &found));
  assert_true(!found.bakeable && found.faults == 1 && found.poses == planned.poses && found.evaluated == 0);
  assert_contains(fb_report_json(report), "nothing to train on");
  fb_verify_result other;
  fb_verify_result_init(&other);
  assert_refused(fb_report_verify(report, &other), FB_ERROR_INVALID_ARGUMENT, "another call");
  fb_report_free(report);

  check.directory = in_folder("dataset"); /* of the test before */
  assert_ok(fb_check(&check, &report));
  assert_ok(fb_report_check(report, &found));
  assert_true(found.bakeable && found.faults == 0 && found.evaluated == found.poses);
  const char* details = NULL;
  assert_ok(fb_report_details(report, &details));
  assert_contains(details, "\"vertex_motion\"");
  fb_report_free(report);
  check.directory = in_folder("nowhere");
  assert_refused(fb_check(&check, NULL), FB_ERROR_NOT_FOUND, "is no folder");
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

static void options_are_listed(void** state) {
  (void)state;
  fb_option_info info;
  int weights = 0;
  for (uint32_t i = 0; i < fb_option_count(); ++i) {
    fb_option_info_init(&info);
    assert_ok(fb_option_at(i, &info));
    assert_true(info.name[0] && info.help[0] && info.since[0] && info.least <= info.most);
    assert_true((info.kind == FB_OPTION_PATH) == (info.standard[0] == 0));
    assert_true((info.kind == FB_OPTION_WORD) == (info.words[0] != 0));
    if (strcmp(info.name, "normal_weight") != 0) continue;
    ++weights;
    assert_true(info.kind == FB_OPTION_NUMBER && info.part == FB_OPTION_FACE && info.least == 0 && info.most == 4);
    assert_string_equal(info.argument, "--normal-weight");
    assert_string_equal(info.standard, "1");
  }
  assert_int_equal(weights, 1);
  assert_refused(fb_option_at(fb_option_count(), &info), FB_ERROR_INVALID_ARGUMENT, "there is no option");
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

/* What a bake with one option by name is refused for. */
static void assert_option_refused(const char* option, const char* reason) {
  fb_bake_desc desc = small_bake("never.fbk");
  desc.options = &option;
  desc.option_count = 1;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, reason);
}

static void options_are_given_by_name(void** state) {
  (void)state;
  fb_bake_desc by_field = small_bake("by_field.fbk"), by_name = small_bake("by_name.fbk");
  by_field.recipe = by_name.recipe = "compact";
  by_field.seed = 7;
  by_field.normal_weight = 0;
  const char* options[] = {"seed=7", "normal_weight=0"};
  by_name.options = options;
  by_name.option_count = 2;
  by_name.seed = 8; /* which the name comes before */
  assert_ok(fb_bake(&by_field, NULL));
  assert_ok(fb_bake(&by_name, NULL));
  assert_same_files(by_field.archive, by_name.archive);
  assert_option_refused("normal_wieght=1",
                        "fb_bake_desc: there is no option \"normal_wieght\"; the closest is \"normal_weight\"");
  assert_option_refused("normal_weight=5", "fb_bake_desc: normal_weight is 5, not 0 to 4");
  assert_option_refused("normal_weight=nan", "normal_weight is nan");
  assert_option_refused("normal_weight=1,5", "normal_weight is \"1,5\"");
  assert_option_refused("seed=-1", "seed is \"-1\"");
  assert_option_refused("epochs=4294967296", "epochs is \"4294967296\"");
  assert_option_refused("force=yes", "force is \"yes\", not 0 or 1");
  assert_option_refused("mix=soup", "mix is \"soup\", none of \"paper\", \"dense\"");
  assert_option_refused("mix", "options[0] is \"mix\", not \"NAME=VALUE\"");
  fb_bake_desc desc = small_bake("never.fbk");
  desc.normal_weight = 5;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "fb_bake_desc: normal_weight is 5, not 0 to 4");
  desc.normal_weight = 1;
  desc.option_count = 1;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "fb_bake_desc: options is null");
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
  for (int phase = FB_PHASE_SAMPLING; phase <= FB_PHASE_MEASURING; ++phase) /* this rig needs no networks */
    assert_int_equal(seen.phases >> phase & 1, phase != FB_PHASE_TRAINING);
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

static void a_shorter_description_has_defaults_beyond_it(void** state) {
  (void)state;
  fb_bake_desc desc = small_bake("shorter.fbk");
  desc.recipe = "linear";
  desc.struct_size = offsetof(fb_bake_desc, max_bytes);
  desc.max_error = -1; /* beyond what an older host knows */
  desc.licence = "beyond";
  assert_ok(fb_bake(&desc, NULL));
  fb_archive* archive = NULL;
  assert_ok(fb_archive_open(desc.archive, &archive));
  fb_archive_info info;
  memset(&info, 0x5a, sizeof info);
  info.struct_size = offsetof(fb_archive_info, licence);
  assert_ok(fb_archive_describe(archive, &info));
  assert_string_equal(info.recipe, "linear");
  assert_int_equal(info.struct_size, offsetof(fb_archive_info, licence));
  assert_int_equal(*(const unsigned char*)&info.licence, 0x5a);
  fb_archive_close(archive);
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

  /* a file where a method's folder is to be */
  desc.work = in_folder("comparison");
  assert_int_equal(run("mkdir", desc.work), 0);
  assert_int_equal(run("touch", in_folder("comparison/kanyuk2018.variant")), 0);
  assert_ok(fb_compare(&desc, &report));
  assert_int_equal(fb_report_method_count(report), 3);
  assert_int_equal(fb_report_failure_count(report), 1);
  fb_failure failure;
  fb_failure_init(&failure);
  assert_ok(fb_report_failure_at(report, 0, &failure));
  assert_string_equal(failure.name, "kanyuk2018");
  assert_int_equal(failure.use, FB_USE_VARIANT);
  assert_contains(failure.reason, "kanyuk2018.variant");
  assert_refused(fb_report_failure_at(report, 1, &failure), FB_ERROR_INVALID_ARGUMENT, "failure 1 of 1");
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(descriptions_have_defaults),
      cmocka_unit_test(a_source_tells_what_it_is),
      cmocka_unit_test(frames_of_a_clip_are_its_controls_evaluated),
      cmocka_unit_test(opening_gives_notes),
      cmocka_unit_test(sampling_writes_a_dataset),
      cmocka_unit_test(plans_wait_for_points),
      cmocka_unit_test(recipes_have_names),
      cmocka_unit_test(options_are_listed),
      cmocka_unit_test(options_are_given_by_name),
      cmocka_unit_test(a_bake_is_measured_for_its_report),
      cmocka_unit_test(a_bake_may_be_stopped_and_goes_on),
      cmocka_unit_test(bakes_that_cannot_be_are_refused),
      cmocka_unit_test(a_shorter_description_has_defaults_beyond_it),
      cmocka_unit_test(methods_are_compared_on_the_same_poses),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
