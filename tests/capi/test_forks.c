/* Batches and bakes in children of fork() and in new processes, whose parents ran loops by this library, by the other
 * one or of their own. Every case is a process of its own, which a time limit ends. */
#define _DEFAULT_SOURCE
#include "capi_test.h"

#include <dirent.h>
#include <dlfcn.h>
#include <facebaker/facebaker_bake.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { controls = 5, floats = 90, poses = 512, threads = 4, limit_seconds = 40 };

/* What a case's process ends with. */
enum { good, no_library, call_failed, threads_missing, no_child };

static const char* program;

/* Finds a function in a library. A cast from an object's address is no C99. */
#define FIND(name)                               \
  do {                                           \
    void* const address = dlsym(library, #name); \
    if (!address) _exit(no_library);             \
    memcpy(&name##_, &address, sizeof address);  \
  } while (0)

static void* open_library(const char* path) {
  void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    fprintf(stderr, "%s\n", dlerror());
    _exit(no_library);
  }
  return library;
}

static int count_threads(void) {
  DIR* tasks = opendir("/proc/self/task");
  if (!tasks) return 0;
  int count = 0;
  for (const struct dirent* entry; (entry = readdir(tasks));) count += entry->d_name[0] != '.';
  closedir(tasks);
  return count;
}

/* Watches how many threads there are at once. */
static volatile int watching, most_threads;

static void* watch_threads(void* nothing) {
  while (watching) {
    const int count = count_threads();
    if (count > most_threads) most_threads = count;
  }
  return nothing;
}

static int batch(void* library) {
  fb_status (*fb_load_)(const char*, const fb_load_desc*, fb_model**);
  fb_status (*fb_scratch_create_)(const fb_model*, uint32_t, fb_scratch**);
  fb_status (*fb_evaluate_batch_)(const fb_model*, fb_scratch*, const fb_batch_desc*);
  void (*fb_batch_desc_fill_)(fb_batch_desc*, uint32_t);
  void (*fb_scratch_destroy_)(fb_scratch*);
  void (*fb_release_)(fb_model*);
  FIND(fb_load);
  FIND(fb_scratch_create);
  FIND(fb_evaluate_batch);
  FIND(fb_batch_desc_fill);
  FIND(fb_scratch_destroy);
  FIND(fb_release);
  static float values[poses * controls], positions[poses * floats];
  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  if (fb_load_(FB_FIXTURE, NULL, &model) != FB_OK) return call_failed;
  fb_batch_desc desc;
  fb_batch_desc_fill_(&desc, sizeof desc);
  desc.threads = threads;
  desc.poses = poses;
  desc.controls = values;
  desc.control_floats = poses * controls;
  desc.positions = positions;
  desc.position_floats = poses * floats;
  int result = fb_scratch_create_(model, threads, &scratch) == FB_OK ? good : call_failed;
  if (result == good && fb_evaluate_batch_(model, scratch, &desc) != FB_OK) result = call_failed;
  fb_scratch_destroy_(scratch);
  fb_release_(model);
  return result;
}

/* A rig of four vertices, the last of which rises with its control. */
static const float square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

static fb_status evaluate_square(void* user, uint64_t count, const float* lift, float* positions, char* message,
                                 uint32_t message_size) {
  (void)user, (void)message, (void)message_size;
  for (uint64_t p = 0; p < count; ++p) {
    memcpy(positions + 12 * p, square, sizeof square);
    positions[12 * p + 11] += lift[p] * lift[p];
  }
  return FB_OK;
}

static int bake(void* library) {
  void (*fb_source_desc_fill_)(fb_source_desc*, uint32_t);
  void (*fb_bake_desc_fill_)(fb_bake_desc*, uint32_t);
  fb_status (*fb_source_open_)(const fb_source_desc*, fb_source**);
  fb_status (*fb_bake_)(const fb_bake_desc*, fb_report**);
  void (*fb_source_close_)(fb_source*);
  FIND(fb_source_desc_fill);
  FIND(fb_bake_desc_fill);
  FIND(fb_source_open);
  FIND(fb_bake);
  FIND(fb_source_close);
  static const fb_rig_control lift = {"lift", NULL, 0, 1, 0, 0};
  static const uint32_t size = 4, corners[4] = {0, 1, 2, 3};
  fb_rig rig;
  fb_rig_init(&rig);
  rig.name = "square";
  rig.units = "m";
  rig.up_axis = "z";
  rig.flags = FB_RIG_THREAD_SAFE;
  rig.control_count = 1;
  rig.controls = &lift;
  rig.vertex_count = 4;
  rig.polygon_count = 1;
  rig.rest_positions = square;
  rig.polygon_sizes = &size;
  rig.polygon_corners = corners;
  rig.evaluate = evaluate_square;
  fb_source_desc source_desc;
  fb_source_desc_fill_(&source_desc, sizeof source_desc);
  source_desc.rig = &rig;
  fb_source* source = NULL;
  if (fb_source_open_(&source_desc, &source) != FB_OK) return call_failed;
  char archive[64];
  snprintf(archive, sizeof archive, "capi_forks_%ld.fbk", (long)getpid());
  fb_bake_desc desc;
  fb_bake_desc_fill_(&desc, sizeof desc);
  desc.source = source;
  desc.archive = archive;
  desc.recipe = "linear";
  desc.poses = 200;
  desc.threads = threads;
  const fb_status status = fb_bake_(&desc, NULL);
  fb_source_close_(source);
  remove(archive);
  return status == FB_OK ? good : call_failed;
}

static void do_nothing(void* nothing) {
  (void)nothing;
}

/* A parallel region of the host, as compilers call it. */
static int loop_of_the_host(void* library) {
  void (*GOMP_parallel_)(void (*)(void*), void*, unsigned, unsigned);
  FIND(GOMP_parallel);
  GOMP_parallel_(do_nothing, NULL, threads, 0);
  return good;
}

static int nothing(void* library) {
  (void)library;
  return good;
}

/* What parents and children do, and with which library. */
typedef struct Work {
  const char* name;
  const char* library;
  int (*run)(void* library);
} Work;
static const Work works[] = {{"batch", FB_LIBRARY, batch},
                             {"bake", FB_BAKE_LIBRARY, bake},
                             {"host", FB_OPENMP_LIBRARY, loop_of_the_host},
                             {"nothing", FB_LIBRARY, nothing}};

static const Work* find_work(const char* name) {
  const Work* work = works;
  while (strcmp(work->name, name) != 0) ++work;
  return work;
}

/* Runs it until as many threads as it may have were seen at once. */
static int run_on_all_threads(const Work* work) {
  void* const library = open_library(work->library);
  pthread_t watcher;
  watching = 1;
  if (pthread_create(&watcher, NULL, watch_threads, NULL) != 0) return no_child;
  int result = good;
  for (int round = 0; result == good && most_threads < threads + 1 && round < 2000; ++round)
    result = work->run(library);
  watching = 0;
  pthread_join(watcher, NULL);
  if (result == good && most_threads < threads + 1) result = threads_missing;
  return result;
}

static int wait_for(pid_t child) {
  int status = 0;
  if (child <= 0 || waitpid(child, &status, 0) != child) return no_child;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/* A parent that does one thing and a child that does another: forked with the child's library, which it would open
 * (loaded) or with none of it (late), or a new program (spawn). */
static int run_case(const char* in_parent, const char* in_child, const char* how) {
  alarm(limit_seconds);
  const Work* const parents = find_work(in_parent);
  if (strcmp(how, "fork") == 0) open_library(find_work(in_child)->library);
  void* const library = strcmp(in_parent, "nothing") == 0 ? NULL : open_library(parents->library);
  const int result = parents->run(library);
  if (result != good) return result;
  const pid_t child = fork();
  if (child == 0) {
    alarm(limit_seconds / 2);
    if (strcmp(how, "spawn") == 0) execl(program, program, in_child, (char*)NULL);
    _exit(run_on_all_threads(find_work(in_child)));
  }
  return wait_for(child);
}

/* All pairs, each in a process of its own. */
static void assert_all_pairs(const char* how) {
  int failed = 0;
  for (int pair = 0; pair < 8; ++pair) {
    const char *const in_parent = works[pair / 2].name, *const in_child = works[pair % 2].name;
    const pid_t child = fork();
    if (child == 0) {
      execl(program, program, in_parent, in_child, how, (char*)NULL);
      _exit(no_child);
    }
    const int result = wait_for(child);
    if (result == good) continue;
    print_error("%s in the parent, %s in its child (%s): %d\n", in_parent, in_child, how, result);
    ++failed;
  }
  assert_int_equal(failed, 0);
}

static void children_that_were_forked(void** state) {
  (void)state;
  assert_all_pairs("fork");
}

static void children_that_load_the_library_themselves(void** state) {
  (void)state;
  assert_all_pairs("late");
}

static void children_that_are_new_programs(void** state) {
  (void)state;
  assert_all_pairs("spawn");
}

int main(int argc, char** argv) {
  program = argv[0];
  if (argc == 2) return run_on_all_threads(find_work(argv[1]));
  if (argc == 4) return run_case(argv[1], argv[2], argv[3]);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(children_that_were_forked),
      cmocka_unit_test(children_that_load_the_library_themselves),
      cmocka_unit_test(children_that_are_new_programs),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
