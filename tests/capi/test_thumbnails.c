/* Thumbnails that a host draws of what fb_bake has baked. */
#include "authoring_fixture.h"

#include <facebaker/facebaker_character.h>

/* A host that draws: what it hands over, and what it saw. */
typedef struct Host {
  fb_status status;    /* that drawing ends with */
  const char* message; /* null: none */
  uint64_t bytes;      /* of the white picture, with zeros behind it, or how many it says it wrote */
  int foreign;         /* 1: no PNG */
  int calls;
} Host;

static unsigned char white[FB_THUMBNAIL_BYTES]; /* a PNG of one pixel */
static uint64_t white_bytes;

static fb_status draw(void* user, const void* archive, uint64_t archive_bytes, void* png, uint64_t* png_bytes,
                      char* message, uint32_t message_size) {
  Host* host = user;
  ++host->calls;
  assert_int_equal(*png_bytes, 0);
  fb_model* model = NULL;
  assert_ok(fb_load_memory(archive, archive_bytes, NULL, &model));
  assert_int_equal(fb_vertex_count(model), vertices);
  uint64_t none = 1;
  assert_null(fb_thumbnail(model, &none));
  fb_release(model);
  if (host->message) snprintf(message, message_size, "%s", host->message);
  if (host->status != FB_OK) return host->status;
  memcpy(png, white, host->bytes < sizeof white ? host->bytes : sizeof white);
  if (host->foreign) memcpy(png, "GIF89a", 6);
  *png_bytes = host->bytes;
  return FB_OK;
}

static fb_bake_desc drawn_bake(const char* name, Host* host) {
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  assert_true(!desc.draw_thumbnail && !desc.thumbnail_user);
  desc.source = toy;
  desc.archive = in_folder(name);
  desc.recipe = "linear";
  desc.poses = 200;
  desc.draw_thumbnail = draw;
  desc.thumbnail_user = host;
  return desc;
}

/* Size of the thumbnail of an archive, 0: none; and the archive's own size, unless null. */
static uint64_t thumbnail_bytes(const char* path, uint64_t* archive_bytes) {
  fb_archive* archive = NULL;
  assert_ok(fb_archive_open(path, &archive));
  assert_ok(fb_verify(archive, NULL));
  fb_archive_info info;
  fb_archive_info_init(&info);
  assert_ok(fb_archive_describe(archive, &info));
  if (info.thumbnail) assert_memory_equal(info.thumbnail, white, info.thumbnail_bytes);
  if (archive_bytes) *archive_bytes = info.byte_count;
  const uint64_t bytes = info.thumbnail_bytes;
  fb_archive_close(archive);
  return bytes;
}

static void a_drawn_thumbnail_is_as_one_that_is_given(void** state) {
  (void)state;
  Host host = {.bytes = white_bytes};
  const fb_bake_desc drawn = drawn_bake("drawn.fbk", &host);
  assert_ok(fb_bake(&drawn, NULL));
  assert_int_equal(host.calls, 1);
  assert_int_equal(thumbnail_bytes(drawn.archive, NULL), white_bytes);
  fb_bake_desc given = drawn_bake("given.fbk", &host);
  given.thumbnail = white;
  given.thumbnail_bytes = white_bytes;
  assert_ok(fb_bake(&given, NULL));
  assert_int_equal(host.calls, 1); /* what is given comes first */
  assert_same_files(drawn.archive, given.archive);
}

static void assert_left_out(Host host, const char* reason) {
  Seen seen;
  fb_bake_desc desc = drawn_bake("left_out.fbk", &host);
  desc.callbacks = watch(&seen);
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(host.calls, 1);
  assert_int_equal(thumbnail_bytes(desc.archive, NULL), 0);
  if (reason)
    assert_contains(seen.note, reason); /* the last note */
  else
    assert_null(strstr(seen.note, "thumbnail"));
  assert_same_files(desc.archive, in_folder("toy.fbk"));
}

static void without_a_picture_the_face_is_baked_all_the_same(void** state) {
  (void)state;
  assert_left_out((Host){.bytes = 0}, NULL);
  assert_left_out((Host){.status = FB_ERROR_IO, .message = "no ink"}, "the archive has no thumbnail: no ink");
  assert_left_out((Host){.status = FB_ERROR_RIG}, "draw_thumbnail returned 11 without a message");
  assert_left_out((Host){.status = -7}, "draw_thumbnail returned -7 without a message");
  assert_left_out((Host){.bytes = white_bytes, .foreign = 1}, "the thumbnail is no PNG");
  assert_left_out((Host){.bytes = 5}, "the thumbnail is no PNG");
  assert_left_out((Host){.bytes = sizeof white + 1}, "draw_thumbnail wrote 65537 bytes; a thumbnail may have 65536");
}

static void drawing_may_stop_a_bake_that_goes_on_later(void** state) {
  (void)state;
  const fb_status stops[] = {FB_ERROR_INTERRUPTED, FB_ERROR_OUT_OF_MEMORY};
  for (size_t i = 0; i < 2; ++i) {
    Host host = {.status = stops[i], .message = "enough", .bytes = white_bytes};
    const fb_bake_desc desc = drawn_bake(i == 0 ? "stopped.fbk" : "full.fbk", &host);
    assert_refused(fb_bake(&desc, NULL), stops[i], "enough");
    assert_int_not_equal(access(desc.archive, F_OK), 0);
    assert_int_equal(access(in_folder(i == 0 ? "stopped.fbk.work" : "full.fbk.work"), F_OK), 0);
    host.status = FB_OK;
    assert_ok(fb_bake(&desc, NULL));
    assert_int_equal(host.calls, 2);
    assert_int_equal(thumbnail_bytes(desc.archive, NULL), white_bytes);
  }
}

static void a_picture_that_a_limit_on_bytes_has_no_room_for_is_left_out(void** state) {
  (void)state;
  Seen seen;
  Host host = {.bytes = white_bytes};
  fb_bake_desc desc = drawn_bake("limited.fbk", &host);
  desc.recipe = "compact";
  desc.epochs = 2;
  desc.callbacks = watch(&seen);
  uint64_t size = 0;
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(thumbnail_bytes(desc.archive, &size), white_bytes);
  desc.max_bytes = size + 20000;
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(thumbnail_bytes(desc.archive, &size), white_bytes);
  host.bytes = sizeof white;
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(thumbnail_bytes(desc.archive, &size), 0);
  assert_true(size <= desc.max_bytes);
  assert_contains(seen.note, "the archive has no thumbnail: with its 65536 bytes the archive has ");
}

/* Bytes of the smallest face that a limit of 4,000 bytes would have to allow. */
static long smallest_reached(Host* host) {
  fb_bake_desc desc = drawn_bake("smallest.fbk", host);
  desc.recipe = "compact";
  desc.epochs = 2;
  desc.max_bytes = 4000;
  if (!host) desc.draw_thumbnail = NULL;
  assert_refused(fb_bake(&desc, NULL), FB_ERROR_LIMIT, "the smallest reached is ");
  const char* const words = "the smallest reached is ";
  return strtol(strstr(fb_last_error(), words) + strlen(words), NULL, 10);
}

static void a_limit_on_bytes_leaves_room_for_a_picture(void** state) {
  (void)state;
  Host host = {.bytes = white_bytes};
  assert_int_equal(smallest_reached(&host) - smallest_reached(NULL), 1000);
  assert_int_equal(host.calls, 0);
}

static void an_older_host_draws_none(void** state) {
  (void)state;
  Host host = {.bytes = white_bytes};
  fb_bake_desc desc = drawn_bake("older.fbk", &host);
  desc.struct_size = offsetof(fb_bake_desc, draw_thumbnail);
  assert_ok(fb_bake(&desc, NULL));
  assert_int_equal(host.calls, 0);
  assert_same_files(desc.archive, in_folder("toy.fbk"));
}

static int set_up_with_picture(void** state) {
  fb_model* character = NULL;
  assert_ok(fb_load(FB_CHARACTER, NULL, &character));
  const void* png = fb_thumbnail(character, &white_bytes);
  memcpy(white, png, white_bytes);
  fb_release(character);
  return set_up(state);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_drawn_thumbnail_is_as_one_that_is_given),
      cmocka_unit_test(without_a_picture_the_face_is_baked_all_the_same),
      cmocka_unit_test(drawing_may_stop_a_bake_that_goes_on_later),
      cmocka_unit_test(a_picture_that_a_limit_on_bytes_has_no_room_for_is_left_out),
      cmocka_unit_test(a_limit_on_bytes_leaves_room_for_a_picture),
      cmocka_unit_test(an_older_host_draws_none),
  };
  return cmocka_run_group_tests(tests, set_up_with_picture, tear_down);
}
