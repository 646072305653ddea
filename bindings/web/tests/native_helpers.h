/* What the C programs of these tests share: memory, errors, and random numbers that are the same everywhere. */
#ifndef FB_NATIVE_HELPERS_H
#define FB_NATIVE_HELPERS_H

#include <facebaker/facebaker.h>
#include <stdio.h>
#include <stdlib.h>

static void* allocate(size_t bytes) {
  void* const memory = calloc(bytes > 0 ? bytes : 1, 1);
  if (!memory) exit(3);
  return memory;
}

static void check(fb_status status) {
  if (status == FB_OK) return;
  fprintf(stderr, "%s: %s\n", fb_status_name(status), fb_last_error());
  exit(1);
}

static uint64_t state = 88172645463325252u;
static float draw(void) { /* xorshift64, in [0, 1) */
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return (float)(state >> 40) / 16777216.0f;
}

#endif
