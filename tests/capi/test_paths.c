/* Paths are UTF-8 on every system, Windows too. */
#include "capi_test.h"

#include <stdio.h>
#include <string.h>

/* "face-", a-umlaut, two Chinese characters, a smiley beyond the 16 bits of UTF-16's units. */
#define NAME "face-\xc3\xa4\xe9\x9d\xa2\xe5\xad\x94\xf0\x9f\x99\x82.fbk"

#ifdef _WIN32
#include <wchar.h>
static const wchar_t wide[] = {'f', 'a', 'c', 'e', '-', 0xe4, 0x9762, 0x5b54, 0xd83d, 0xde42, '.', 'f', 'b', 'k', 0};
static FILE* create(void) {
  return _wfopen(wide, L"wb");
}
static int delete_it(void) {
  return _wremove(wide);
}
#else
static FILE* create(void) {
  return fopen(NAME, "wb");
}
static int delete_it(void) {
  return remove(NAME);
}
#endif

static int copy_the_fixture(void** state) {
  static char bytes[1 << 16];
  FILE *from = fopen(FB_FIXTURE, "rb"), *to = create();
  (void)state;
  if (!from || !to) return 1;
  const size_t size = fread(bytes, 1, sizeof bytes, from);
  const int written = size > 0 && fwrite(bytes, 1, size, to) == size;
  fclose(from);
  return fclose(to) != 0 || !written;
}

static int remove_the_copy(void** state) {
  (void)state;
  return delete_it();
}

static void a_face_is_loaded_by_a_name_of_any_script(void** state) {
  (void)state;
  for (uint32_t map = 0; map < 2; ++map) {
    fb_load_desc desc;
    fb_load_desc_init(&desc);
    desc.map_file = map;
    fb_model* model = NULL;
    assert_ok(fb_load(NAME, &desc, &model));
    assert_int_equal(fb_vertex_count(model), 30);
    fb_release(model);
  }
}

static void messages_name_it_in_utf8(void** state) {
  (void)state;
  fb_model* model = NULL;
  assert_int_equal(fb_load("no-" NAME, NULL, &model), FB_ERROR_NOT_FOUND);
  assert_string_equal(fb_last_error(), "no such file (no-" NAME ")");
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.max_file_bytes = 10;
  assert_int_equal(fb_load(NAME, &desc, &model), FB_ERROR_LIMIT);
  assert_non_null(strstr(fb_last_error(), "(" NAME ")"));
}

static void folders_are_refused(void** state) {
  (void)state;
  fb_model* model = NULL;
  assert_int_equal(fb_load(".", NULL, &model), FB_ERROR_IO);
  assert_string_equal(fb_last_error(), "is a directory, not a file (.)");
  assert_int_equal(fb_load("no such folder/face.fbk", NULL, &model), FB_ERROR_NOT_FOUND);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_face_is_loaded_by_a_name_of_any_script),
      cmocka_unit_test(messages_name_it_in_utf8),
      cmocka_unit_test(folders_are_refused),
  };
  return cmocka_run_group_tests(tests, copy_the_fixture, remove_the_copy);
}
