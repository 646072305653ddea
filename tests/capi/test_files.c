/* Where archives come from: files, which may change while they are loaded, what is no regular file, and streams. */
#define _DEFAULT_SOURCE
#include "capi_test.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static unsigned char fixture[1 << 16];
static size_t fixture_size;
static char folder[] = "/tmp/facebaker-files-XXXXXX";
static char path[64];

static int make_file(void** state) {
  (void)state;
  FILE* file = fopen(FB_FIXTURE, "rb");
  if (!file) return -1;
  fixture_size = fread(fixture, 1, sizeof fixture, file);
  fclose(file);
  if (!mkdtemp(folder)) return -1;
  snprintf(path, sizeof path, "%s/face", folder);
  return 0;
}

static int remove_files(void** state) {
  (void)state;
  unlink(path);
  return rmdir(folder);
}

static void write_fixture(void) {
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(fixture, 1, fixture_size, file), fixture_size);
  fclose(file);
}

static void assert_refused(fb_status got, fb_status expected, const char* message_part) {
  assert_int_equal(got, expected);
  if (!strstr(fb_last_error(), message_part)) fail_msg("\"%s\" does not contain \"%s\"", fb_last_error(), message_part);
}

static void a_file_may_be_read_or_mapped(void** state) {
  (void)state;
  write_fixture();
  for (uint32_t map = 0; map < 2; ++map) {
    fb_model* model = NULL;
    fb_load_desc desc;
    fb_load_desc_init(&desc);
    desc.map_file = map;
    assert_ok(fb_load(path, &desc, &model));
    assert_int_equal(fb_vertex_count(model), 30);
    fb_release(model);
    desc.max_file_bytes = fixture_size - 1;
    assert_refused(fb_load(path, &desc, &model), FB_ERROR_LIMIT, "limit");
  }
  assert_int_equal(truncate(path, 0), 0);
  fb_model* model = NULL;
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.map_file = 1;
  assert_refused(fb_load(path, &desc, &model), FB_ERROR_NOT_AN_ARCHIVE, "empty");
}

/* As "cp new.fbk face.fbk" does. */
static void overwrite_again_and_again(void) {
  const int file = open(path, O_WRONLY);
  for (;;)
    if (ftruncate(file, 0) != 0 || pwrite(file, fixture, fixture_size, 0) < 0) _exit(1);
}

static void a_file_cut_short_while_it_is_loaded_is_refused(void** state) {
  (void)state;
  write_fixture();
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) overwrite_again_and_again();
  int loaded = 0, refused = 0;
  for (int round = 0; round < 100000 && (round < 2000 || loaded == 0 || refused == 0); ++round) {
    fb_model* model = NULL;
    const fb_status status = fb_load(path, NULL, &model);
    fb_release(model);
    assert_true(status == FB_OK || status == FB_ERROR_CORRUPT || status == FB_ERROR_NOT_AN_ARCHIVE);
    *(status == FB_OK ? &loaded : &refused) += 1;
  }
  kill(child, SIGKILL);
  waitpid(child, NULL, 0);
  assert_true(loaded > 0 && refused > 0);
}

static void only_regular_files_are_read_by_path(void** state) {
  (void)state;
  fb_model* model = NULL;
  alarm(20); /* a pipe without a writer would wait for ever */
  unlink(path);
  assert_int_equal(mkfifo(path, 0600), 0);
  assert_refused(fb_load(path, NULL, &model), FB_ERROR_IO, "no regular file");
  unlink(path);
  assert_refused(fb_load("/dev/zero", NULL, &model), FB_ERROR_IO, "no regular file");
  assert_refused(fb_load(folder, NULL, &model), FB_ERROR_IO, "directory");
  alarm(0);
  write_fixture();
}

static void the_reason_comes_before_a_long_path(void** state) {
  (void)state;
  char longest[4000] = "/nowhere";
  while (strlen(longest) + 110 < sizeof longest) {
    strcat(longest, "/");
    for (int i = 0; i < 50; ++i) strcat(longest, "\xc3\xa4");
  }
  strcat(longest, "/face.fbk");
  fb_model* model = NULL;
  assert_int_equal(fb_load(longest, NULL, &model), FB_ERROR_NOT_FOUND);
  const char* message = fb_last_error();
  assert_memory_equal(message, "no such file (/nowhere/", 23);
  assert_non_null(strstr(message, "\xc3\xa4...\xc3\xa4"));
  assert_string_equal(message + strlen(message) - 10, "/face.fbk)");
  assert_true(strlen(message) < 300);
}

/* A stream over bytes that gives at most `step` of them at once. */
typedef struct Stream {
  const unsigned char* bytes;
  size_t size, at, step;
  int64_t result; /* what read returns instead, if not 0 */
} Stream;

static int64_t read_stream(void* user, void* to, uint64_t bytes) {
  Stream* stream = user;
  assert_true(bytes > 0);
  if (stream->result != 0) return stream->result;
  size_t count = stream->size - stream->at;
  if (count > bytes) count = (size_t)bytes;
  if (count > stream->step) count = stream->step;
  memcpy(to, stream->bytes + stream->at, count);
  stream->at += count;
  return (int64_t)count;
}

static void an_archive_is_read_from_a_stream(void** state) {
  (void)state;
  memset(fixture + fixture_size, 0x5a, 100); /* what follows the archive */
  const size_t steps[] = {1, 7, 1 << 16};
  for (int i = 0; i < 3; ++i) {
    Stream stream = {fixture, fixture_size + 100, 0, steps[i], 0};
    fb_model* model = NULL;
    assert_ok(fb_load_stream(read_stream, &stream, NULL, &model));
    assert_int_equal(stream.at, fixture_size);
    assert_int_equal(fb_vertex_count(model), 30);
    fb_release(model);
  }
}

static void a_stream_that_fails_is_refused(void** state) {
  (void)state;
  fb_model* model = NULL;
  for (size_t size = 0; size < fixture_size; size += 97) {
    Stream stream = {fixture, size, 0, 1000, 0};
    const fb_status status = fb_load_stream(read_stream, &stream, NULL, &model);
    assert_true(status == FB_ERROR_CORRUPT || (size == 0 && status == FB_ERROR_NOT_AN_ARCHIVE));
  }
  Stream broken = {fixture, fixture_size, 0, 1000, -1};
  assert_refused(fb_load_stream(read_stream, &broken, NULL, &model), FB_ERROR_IO, "stream");
  broken.result = 25;
  assert_refused(fb_load_stream(read_stream, &broken, NULL, &model), FB_ERROR_INVALID_ARGUMENT, "returned 25");
  assert_refused(fb_load_stream(NULL, NULL, NULL, &model), FB_ERROR_INVALID_ARGUMENT, "read");
  assert_refused(fb_load_stream(read_stream, &broken, NULL, NULL), FB_ERROR_INVALID_ARGUMENT, "model");
  const char text[] = "GIF89a, and so on and so on and so on";
  Stream other = {(const unsigned char*)text, sizeof text, 0, 1000, 0};
  assert_refused(fb_load_stream(read_stream, &other, NULL, &model), FB_ERROR_NOT_AN_ARCHIVE, "signature");
  assert_null(model);
}

static void a_stream_does_not_exceed_the_limits(void** state) {
  (void)state;
  fb_model* model = NULL;
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  Stream stream = {fixture, fixture_size, 0, 1000, 0};
  desc.max_file_bytes = fixture_size - 1;
  assert_refused(fb_load_stream(read_stream, &stream, &desc, &model), FB_ERROR_LIMIT, "more than the limit");
  assert_int_equal(stream.at, 24); /* the header alone */
  fb_load_desc_init(&desc);
  desc.max_model_bytes = (uint64_t)1 << 20;
  static unsigned char lie[24];
  memcpy(lie, fixture, sizeof lie);
  lie[19] = 0xc0; /* 3 GiB */
  Stream liar = {lie, sizeof lie, 0, 1000, 0};
  assert_refused(fb_load_stream(read_stream, &liar, &desc, &model), FB_ERROR_LIMIT, "limit of 1048576 bytes");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_file_may_be_read_or_mapped),
      cmocka_unit_test(a_file_cut_short_while_it_is_loaded_is_refused),
      cmocka_unit_test(only_regular_files_are_read_by_path),
      cmocka_unit_test(the_reason_comes_before_a_long_path),
      cmocka_unit_test(an_archive_is_read_from_a_stream),
      cmocka_unit_test(a_stream_that_fails_is_refused),
      cmocka_unit_test(a_stream_does_not_exceed_the_limits),
  };
  return cmocka_run_group_tests(tests, make_file, remove_files);
}
