/* A library to preload that makes file-system calls fail: of those on paths below FB_FAULT_FOLDER and of the kinds in
 * FB_FAULT_KINDS ("open,write,..."; see `kinds`), the one numbered FB_FAULT_AT, counted from 1, and with
 * FB_FAULT_STAYS all after it. They fail with the errno FB_FAULT_ERROR; if that is 0, the folder is renamed to
 * "<folder>.gone" first and the call goes on. What failed is then written to the file FB_FAULT_MARK. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

/* "open": for reading; "create": for writing; "remove": of files and folders. */
static const char kinds[] = "open,create,read,write,sync,rename,mkdir,truncate,remove,lock";

static const char *folder, *chosen, *mark_path;
static size_t folder_length;
static long fails_at;
static int error_number, stays;
static atomic_long count;

__attribute__((constructor)) static void read_settings(void) {
  folder = getenv("FB_FAULT_FOLDER");
  chosen = getenv("FB_FAULT_KINDS");
  mark_path = getenv("FB_FAULT_MARK");
  if (!folder || !mark_path) return;
  if (!chosen) chosen = kinds;
  fails_at = atol(getenv("FB_FAULT_AT"));
  error_number = atoi(getenv("FB_FAULT_ERROR"));
  stays = getenv("FB_FAULT_STAYS") != NULL;
  folder_length = strlen(folder);
}

static int below_folder(const char* path) {
  return folder_length > 0 && strncmp(path, folder, folder_length) == 0 &&
         (path[folder_length] == '/' || path[folder_length] == '\0');
}

static void leave_mark(const char* kind, const char* path) {
  const long file = syscall(SYS_openat, AT_FDCWD, mark_path, O_WRONLY | O_CREAT | O_APPEND, 0666);
  char line[4200];
  const int length = snprintf(line, sizeof line, "%s %s\n", kind, path);
  syscall(SYS_write, file, line, length);
  syscall(SYS_close, file);
}

/* Whether this call is to fail; sets errno then. */
static int fails(const char* kind, const char* path) {
  if (!path || !below_folder(path) || !strstr(chosen, kind)) return 0;
  const long number = atomic_fetch_add(&count, 1) + 1;
  if (number < fails_at || (number > fails_at && !stays)) return 0;
  leave_mark(kind, path);
  if (error_number != 0) {
    errno = error_number;
    return 1;
  }
  char gone[4200];
  snprintf(gone, sizeof gone, "%s.gone", folder);
  syscall(SYS_renameat2, AT_FDCWD, folder, AT_FDCWD, gone, 0);
  return 0;
}

static int file_fails(const char* kind, int file) {
  char name[64], path[4097];
  if (folder_length == 0) return 0;
  snprintf(name, sizeof name, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(name, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = '\0';
  return fails(kind, path);
}

/* The function that this library stands before. */
#define NEXT(name)               \
  static __typeof__(name)* next; \
  if (!next) *(void**)&next = dlsym(RTLD_NEXT, #name)

static const char* kind_of_open(int flags) {
  return (flags & O_ACCMODE) == O_RDONLY ? "open" : "create";
}

#define OPEN(name)                                                                \
  int name(const char* path, int flags, ...) {                                    \
    NEXT(name);                                                                   \
    va_list list;                                                                 \
    va_start(list, flags);                                                        \
    const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(list, mode_t) : 0; \
    va_end(list);                                                                 \
    return fails(kind_of_open(flags), path) ? -1 : next(path, flags, mode);       \
  }
OPEN(open)
OPEN(open64)

#define FOPEN(name)                                                                                         \
  FILE* name(const char* path, const char* mode) {                                                          \
    NEXT(name);                                                                                             \
    return fails(mode[0] == 'r' && !strchr(mode, '+') ? "open" : "create", path) ? NULL : next(path, mode); \
  }
FOPEN(fopen)
FOPEN(fopen64)

/* A call on an open file that returns -1 if it fails. */
#define ON_FILE(kind, type, name, parameters, ...)          \
  type name parameters {                                    \
    NEXT(name);                                             \
    return file_fails(kind, file) ? -1 : next(__VA_ARGS__); \
  }
ON_FILE("read", ssize_t, read, (int file, void* to, size_t size), file, to, size)
ON_FILE("read", ssize_t, pread, (int file, void* to, size_t size, off_t at), file, to, size, at)
ON_FILE("read", ssize_t, pread64, (int file, void* to, size_t size, off64_t at), file, to, size, at)
ON_FILE("write", ssize_t, write, (int file, const void* from, size_t size), file, from, size)
ON_FILE("write", ssize_t, writev, (int file, const struct iovec* from, int parts), file, from, parts)
ON_FILE("sync", int, fsync, (int file), file)
ON_FILE("truncate", int, ftruncate, (int file, off_t size), file, size)
ON_FILE("lock", int, flock, (int file, int operation), file, operation)

/* A call on a path that returns -1 if it fails. */
#define ON_PATH(kind, name, parameters, ...)           \
  int name parameters {                                \
    NEXT(name);                                        \
    return fails(kind, path) ? -1 : next(__VA_ARGS__); \
  }
ON_PATH("rename", rename, (const char* path, const char* to), path, to)
ON_PATH("mkdir", mkdir, (const char* path, mode_t mode), path, mode)
ON_PATH("truncate", truncate, (const char* path, off_t size), path, size)
ON_PATH("truncate", truncate64, (const char* path, off64_t size), path, size)
ON_PATH("remove", unlink, (const char* path), path)
ON_PATH("remove", remove, (const char* path), path)
ON_PATH("remove", rmdir, (const char* path), path)

/* With a folder's descriptor, as std::filesystem::remove_all calls it. */
int unlinkat(int file, const char* path, int flags) {
  NEXT(unlinkat);
  return (path[0] == '/' ? fails("remove", path) : file_fails("remove", file)) ? -1 : next(file, path, flags);
}
