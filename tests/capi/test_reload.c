/* A host that reloads its plugins: a library is opened, used on several threads and closed again, 100 times. The
 * threads that OpenMP keeps must find their code afterwards. */
#include "capi_test.h"

#include <dirent.h>
#include <dlfcn.h>
#include <string.h>
#include <unistd.h>

#define ROUNDS 100
#define POSES 64
#define THREADS 4

static float controls[POSES * 5], positions[POSES * 90], first[POSES * 90];

static int count_threads(void) {
  DIR* tasks = opendir("/proc/self/task");
  if (!tasks) return 0;
  int count = 0;
  while (readdir(tasks)) ++count;
  closedir(tasks);
  return count - 2; /* . and .. */
}

/* Finds a function of the library. A cast from an object's address is no C99. */
#define FIND(name)                               \
  do {                                           \
    void* const address = dlsym(library, #name); \
    assert_non_null(address);                    \
    memcpy(&name##_, &address, sizeof address);  \
  } while (0)

static void pose_on_threads(void* library) {
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
  fb_model* model = NULL;
  fb_scratch* scratch = NULL;
  assert_ok(fb_load_(FB_FIXTURE, NULL, &model));
  assert_ok(fb_scratch_create_(model, THREADS, &scratch));
  fb_batch_desc desc;
  fb_batch_desc_fill_(&desc, sizeof desc);
  desc.threads = THREADS;
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * 5;
  desc.positions = positions;
  desc.position_floats = POSES * 90;
  assert_ok(fb_evaluate_batch_(model, scratch, &desc));
  fb_scratch_destroy_(scratch);
  fb_release_(model);
}

static void open_and_close(const char* path) {
  for (int i = 0; i < POSES * 5; ++i) controls[i] = 0.1f * (float)(i % 9);
  for (int round = 0; round < ROUNDS; ++round) {
    void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail_msg("%s", dlerror());
    pose_on_threads(library);
    if (FB_HAS_OPENMP && count_threads() > 0) assert_true(count_threads() >= THREADS); /* idle, in OpenMP's code */
    if (round == 0) memcpy(first, positions, sizeof first);
    assert_memory_equal(positions, first, sizeof first);
    assert_int_equal(dlclose(library), 0);
    if (round % 10 == 0) usleep(20000); /* time for the idle threads to stop spinning */
  }
}

static void the_runtime_survives_being_closed_and_opened(void** state) {
  (void)state;
  open_and_close(FB_LIBRARY);
}

static void the_authoring_library_survives_it_too(void** state) {
  (void)state;
  open_and_close(FB_BAKE_LIBRARY);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_runtime_survives_being_closed_and_opened),
      cmocka_unit_test(the_authoring_library_survives_it_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
