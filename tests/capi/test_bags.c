/* Bags through the C interface. */
#include "authoring_fixture.h"

static const char* face_path;

static fb_bag_desc bag_desc(const char* directory) {
  fb_bag_desc desc;
  fb_bag_desc_init(&desc);
  desc.directory = directory;
  desc.archives = &face_path;
  desc.archive_count = 1;
  desc.date = "2026-11-29";
  return desc;
}

static fb_bag_result result_of(const fb_report* report) {
  fb_bag_result result;
  fb_bag_result_init(&result);
  assert_ok(fb_report_bag(report, &result));
  return result;
}

static fb_status copy_text(void* user, uint32_t archive, const char* base, char* message, uint32_t message_size) {
  if (!user) {
    snprintf(message, message_size, "no copy of archive %u", archive);
    return FB_ERROR_LIMIT;
  }
  char path[512];
  snprintf(path, sizeof path, "%s.txt", base);
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  fputs((const char*)user, file);
  fclose(file);
  return FB_OK;
}

static void a_bag_is_written_and_checked(void** state) {
  (void)state;
  char bag[160];
  snprintf(bag, sizeof bag, "%s", in_folder("bag"));
  Seen seen;
  fb_bag_desc desc = bag_desc(bag);
  const char *const names[1] = {"other/face"}, *const info[1] = {"Contact-Name: A. Keeper"};
  desc.file_names = names;
  desc.files = &face_path;
  desc.file_count = 1;
  desc.info = info;
  desc.info_count = 1;
  desc.make_copies = copy_text;
  desc.callbacks = watch(&seen);
  assert_refused(fb_bag(&desc, NULL), FB_ERROR_LIMIT, "no copy of archive 0");
  assert_int_not_equal(run("test -e", bag), 0);
  char words[] = "a picture in words";
  desc.copies_user = words;
  fb_report* report = NULL;
  assert_ok(fb_bag(&desc, &report));
  assert_true(seen.stages >= 4);
  const fb_bag_result written = result_of(report);
  assert_true(written.valid && written.archives == 2 && written.faults == 0 && written.files > 20);
  assert_contains(fb_report_json(report), "\"Contact-Name\"");
  fb_report_free(report);
  char path[256];
  snprintf(path, sizeof path, "%s/data/other/face", bag);
  assert_same_files(path, face_path);

  fb_bag_check_desc check;
  fb_bag_check_desc_init(&check);
  assert_refused(fb_bag_check(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "directory");
  check.directory = bag;
  check.callbacks = watch(&seen);
  assert_ok(fb_bag_check(&check, &report));
  assert_true(result_of(report).valid && result_of(report).bytes == written.bytes);
  fb_check_result other;
  fb_check_result_init(&other);
  assert_refused(fb_report_check(report, &other), FB_ERROR_INVALID_ARGUMENT, "another call");
  fb_report_free(report);
  assert_int_equal(remove(path), 0);
  assert_ok(fb_bag_check(&check, &report));
  assert_true(!result_of(report).valid && result_of(report).faults == 2);
  assert_contains(fb_report_json(report), "is missing; manifest-sha512.txt names it");
  fb_report_free(report);
  seen.stop_after = 1;
  assert_int_equal(fb_bag_check(&check, NULL), FB_ERROR_INTERRUPTED);
}

static void what_is_wrong_with_a_description_is_named(void** state) {
  (void)state;
  fb_bag_desc desc = bag_desc(in_folder("refused"));
  desc.date = "yesterday";
  assert_refused(fb_bag(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "give a day as 2026-11-29");
  desc = bag_desc(in_folder("refused"));
  desc.archives = NULL;
  assert_refused(fb_bag(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "archives");
  desc.archive_count = 0;
  assert_refused(fb_bag(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "there is no archive");
  desc = bag_desc(NULL);
  assert_refused(fb_bag(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "directory");
  assert_int_equal(fb_report_bag(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
}

static int set_up_face(void** state) {
  static char path[160];
  const int failed = set_up(state);
  snprintf(path, sizeof path, "%s", in_folder("toy.fbk"));
  face_path = path;
  return failed;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bag_is_written_and_checked),
      cmocka_unit_test(what_is_wrong_with_a_description_is_named),
  };
  return cmocka_run_group_tests(tests, set_up_face, tear_down);
}
