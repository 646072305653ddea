/* Signatures through the C interface: what fb_sign writes, fb_verify_signature reads, and what both refuse. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <facebaker/facebaker_sign.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "signing_files.h"

static char folder[] = "/tmp/facebaker-sign-XXXXXX", key[64], trusted[64], other[64], out[64];

static void assert_refused(fb_status status, fb_status expected, const char* message_part) {
  assert_int_equal(status, expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("%s has no %s", fb_last_error(), message_part);
}

static int make_files(void** state) {
  (void)state;
  assert_non_null(mkdtemp(folder));
  write_signing_files(folder);
  snprintf(key, sizeof key, "%s/key.pem", folder);
  snprintf(trusted, sizeof trusted, "%s/signer.pem", folder);
  snprintf(other, sizeof other, "%s/other.pem", folder);
  snprintf(out, sizeof out, "%s/face.sig", folder);
  return 0;
}

static int remove_files(void** state) {
  (void)state;
  for (const char* const* file = (const char* const[]){key, trusted, other, out, NULL}; *file; ++file) unlink(*file);
  return rmdir(folder);
}

static fb_sign_desc signing(void) {
  fb_sign_desc desc;
  fb_sign_desc_init(&desc);
  desc.path = FB_FIXTURE;
  desc.key = key;
  desc.signature = out;
  return desc;
}

static fb_verify_signature_desc verifying(const char* const* files) {
  fb_verify_signature_desc desc;
  fb_verify_signature_desc_init(&desc);
  desc.path = FB_FIXTURE;
  desc.signature = out;
  desc.trusted = files;
  desc.trusted_count = files ? 1 : 0;
  return desc;
}

static void a_signature_is_read_of_a_path_and_of_an_archive(void** state) {
  (void)state;
  const fb_sign_desc desc = signing();
  fb_report* report = NULL;
  assert_ok(fb_sign(&desc, &report));
  assert_non_null(strstr(fb_report_json(report), "\"subject\": \"CN = Ada\""));
  fb_report_free(report);
  assert_ok(fb_sign(&desc, NULL));

  const char* const files[] = {trusted};
  fb_verify_signature_desc check = verifying(files);
  assert_ok(fb_verify_signature(&check, &report));
  assert_non_null(strstr(fb_report_json(report), "\"by\": \"certificate\""));
  fb_report_free(report);
  fb_archive* archive = NULL;
  assert_ok(fb_archive_open(FB_FIXTURE, &archive));
  check.archive = archive;
  check.path = NULL;
  assert_ok(fb_verify_signature(&check, NULL));
  check.on = "2020-01-01";
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_BAD_DATA, "which is after 2020-01-01");
  check.on = "today";
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "today is no day");
  fb_archive_close(archive);
}

static void what_is_missing_or_wrong_is_named(void** state) {
  (void)state;
  fb_sign_desc desc = signing();
  assert_ok(fb_sign(&desc, NULL));
  desc.key = NULL;
  assert_refused(fb_sign(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "fb_sign_desc: key");
  desc = signing();
  desc.path = NULL;
  assert_refused(fb_sign(&desc, NULL), FB_ERROR_INVALID_ARGUMENT, "fb_sign_desc: path");
  desc = signing();
  desc.pass_phrase = "needless";
  assert_ok(fb_sign(&desc, NULL));
  assert_refused(fb_sign(NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "desc");

  const char *const others[] = {other}, *const none[] = {NULL};
  fb_verify_signature_desc check = verifying(others);
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_BAD_DATA, "somebody who is not trusted: CN = Ada");
  check = verifying(NULL);
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_BAD_DATA,
                 "no certificate or key is given that is trusted");
  check = verifying(none);
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "trusted");
  check.trusted = NULL;
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "trusted");
  check = verifying(others);
  check.withdrawn_count = 1;
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_BAD_DATA, "not trusted");
  check = verifying(others);
  check.flags = 2;
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "flags");
  check = verifying(others);
  check.path = NULL;
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_INVALID_ARGUMENT, "path");
  check.path = FB_TEXT_FILE;
  assert_refused(fb_verify_signature(&check, NULL), FB_ERROR_BAD_DATA, "is of other bytes");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_signature_is_read_of_a_path_and_of_an_archive),
      cmocka_unit_test(what_is_missing_or_wrong_is_named),
  };
  return cmocka_run_group_tests(tests, make_files, remove_files);
}
