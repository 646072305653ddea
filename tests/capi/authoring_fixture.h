/* A folder, the toy rig and a face of it, for tests of the authoring calls. */
#ifndef AUTHORING_FIXTURE_H
#define AUTHORING_FIXTURE_H

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

static inline const char* in_folder(const char* name) {
  static char paths[8][160];
  static unsigned next;
  char* path = paths[next++ % 8];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  return path;
}

static inline int run(const char* command, const char* path) {
  char line[256];
  snprintf(line, sizeof line, "%s %s", command, path);
  return system(line);
}

static inline void assert_contains(const char* text, const char* part) {
  if (!strstr(text, part)) fail_msg("there is no %s in %.300s", part, text);
}

static inline void assert_refused(fb_status status, fb_status expected, const char* message_part) {
  if (status != expected) fail_msg("%s (%s), not %s", fb_status_name(status), fb_last_error(), message_part);
  assert_contains(fb_last_error(), message_part);
}

static inline void assert_same_files(const char* first, const char* second) {
  FILE *a = fopen(first, "rb"), *b = fopen(second, "rb");
  assert_true(a && b);
  for (int byte = 0; byte != EOF;) {
    byte = fgetc(a);
    assert_int_equal(byte, fgetc(b));
  }
  fclose(a);
  fclose(b);
}

/* What a host sees of a call. */
typedef struct Seen {
  int stages, calls, notes;
  unsigned phases; /* a bit for each, FB_PHASE_... */
  int stop_after; /* calls; 0: never */
  char note[512];
} Seen;

static inline int32_t see_progress(void* user, const char* stage, uint64_t done, uint64_t total) {
  Seen* seen = user;
  assert_true(*stage && done <= total);
  assert_in_range(fb_progress_phase(), FB_PHASE_SAMPLING, FB_PHASE_WRITING);
  seen->phases |= 1u << fb_progress_phase();
  seen->stages += done == 0;
  ++seen->calls;
  return seen->stop_after > 0 && seen->calls >= seen->stop_after;
}

static inline void see_note(void* user, const char* sentence) {
  Seen* seen = user;
  ++seen->notes;
  snprintf(seen->note, sizeof seen->note, "%s", sentence);
}

static inline fb_callbacks watch(Seen* seen) {
  memset(seen, 0, sizeof *seen);
  const fb_callbacks callbacks = {seen, see_progress, see_note};
  return callbacks;
}

static inline fb_source* open_paths(const char* const* paths, uint32_t count, Seen* seen) {
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = paths;
  desc.path_count = count;
  desc.callbacks = watch(seen);
  fb_source* source = NULL;
  assert_ok(fb_source_open(&desc, &source));
  return source;
}

static inline fb_source_info describe(const fb_source* source) {
  fb_source_info info;
  fb_source_info_init(&info);
  assert_ok(fb_source_describe(source, &info));
  return info;
}

static inline int set_up(void** state) {
  (void)state;
  Seen seen;
  snprintf(folder, sizeof folder, "capi_authoring_%ld", (long)getpid());
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

static inline int tear_down(void** state) {
  (void)state;
  fb_archive_close(toy_face);
  fb_source_close(toy);
  return run("rm -rf", folder);
}

#endif
