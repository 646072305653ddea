/* A library to preload that makes one allocation of a program fail: the one numbered FB_FAULT_AT, counted from 1, in
 * the program of the name FB_FAULT_PROGRAM alone, not in its children. Those before main() do not count. Writes how
 * many there were to the file FB_FAULT_MARK when the program ends. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern void* __libc_malloc(size_t bytes);
extern void* __libc_calloc(size_t count, size_t bytes);
extern void* __libc_realloc(void* memory, size_t bytes);
extern void* __libc_memalign(size_t alignment, size_t bytes);

typedef int Main(int, char**, char**);

static atomic_long count;
static long fails_at;
static int counts;
static Main* program_main;

static int counted_main(int words, char** word, char** environment) {
  const char *const at = getenv("FB_FAULT_AT"), *const program = getenv("FB_FAULT_PROGRAM");
  if (at && program && strcmp(program, program_invocation_short_name) == 0) {
    fails_at = atol(at);
    counts = 1;
  }
  return program_main(words, word, environment);
}

/* What calls main(), once constructors have run. */
int __libc_start_main(Main* main, int words, char** word, void (*init)(void), void (*fini)(void),
                      void (*loader_fini)(void), void* stack_end) {
  __typeof__(__libc_start_main)* const next = (__typeof__(next))dlsym(RTLD_NEXT, "__libc_start_main");
  program_main = main;
  return next(counted_main, words, word, init, fini, loader_fini, stack_end);
}

__attribute__((destructor)) static void leave_mark(void) {
  const char* const path = getenv("FB_FAULT_MARK");
  if (!counts || !path) return;
  char line[32];
  const int length = snprintf(line, sizeof line, "%ld", atomic_load(&count));
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0 || write(file, line, (size_t)length) != length) abort();
  close(file);
}

static int fails(void) {
  if (!counts || atomic_fetch_add(&count, 1) + 1 != fails_at) return 0;
  errno = ENOMEM;
  return 1;
}

void* malloc(size_t bytes) {
  return fails() ? NULL : __libc_malloc(bytes);
}
void* calloc(size_t number, size_t bytes) {
  return fails() ? NULL : __libc_calloc(number, bytes);
}
void* realloc(void* memory, size_t bytes) {
  return fails() ? NULL : __libc_realloc(memory, bytes);
}
void* memalign(size_t alignment, size_t bytes) {
  return fails() ? NULL : __libc_memalign(alignment, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  return fails() ? NULL : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
  if (fails()) return ENOMEM;
  *memory = __libc_memalign(alignment, bytes);
  return *memory ? 0 : ENOMEM;
}
