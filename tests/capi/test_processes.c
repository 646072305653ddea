/* Batches in processes that threads are scarce in: children of fork(), and under limits of the system. */
#define _DEFAULT_SOURCE
#define POSES 256
#define WORKERS 64
#include "batch_fixture.h"

#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static float positions[POSES * FLOATS];

static const char* program;

/* What a child ends with: 0 if its batch is right. */
static int pose(uint32_t threads) {
  memset(positions, 0, sizeof positions);
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.threads = threads;
  if (fb_evaluate_batch(model, scratch, &desc) != FB_OK) return 3;
  return memcmp(positions, expected, sizeof expected) == 0 ? 0 : 4;
}

static void assert_ends_well(pid_t child) {
  int status = 0;
  assert_true(child > 0);
  assert_int_equal(waitpid(child, &status, 0), child);
  if (WIFSIGNALED(status)) fail_msg("the child was ended by signal %d", WTERMSIG(status));
  assert_int_equal(WEXITSTATUS(status), 0);
}

static void a_child_of_fork_poses(void** state) {
  (void)state;
  assert_int_equal(pose(4), 0); /* leaves threads behind, which a child does not have */
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    int result = pose(4);
    const pid_t grandchild = result == 0 ? fork() : -1;
    if (grandchild == 0) _exit(pose(4));
    int status = 0;
    if (result == 0 && (waitpid(grandchild, &status, 0) != grandchild || status != 0)) result = 5;
    _exit(result);
  }
  assert_ends_well(child);
  assert_int_equal(pose(4), 0);
}

/* Runs this program anew, to pose on WORKERS threads under a limit. */
static void assert_poses_under(const char* limit) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    execl(program, program, limit, (char*)NULL);
    _exit(127);
  }
  assert_ends_well(child);
}

static void too_little_memory_for_all_threads(void** state) {
  (void)state;
  assert_poses_under("memory");
}

static void fewer_threads_than_asked_for(void** state) {
  (void)state;
  assert_poses_under("threads");
}

static int limited(const char* limit) {
  if (open_model(NULL) != 0) return 6;
  const int memory = strcmp(limit, "memory") == 0;
  const rlim_t most = memory ? (rlim_t)400000 * 1024 : 8;
  const struct rlimit set = {most, most};
  if (setrlimit(memory ? RLIMIT_AS : RLIMIT_NPROC, &set) != 0) return 7;
  if (!memory && geteuid() == 0 && setuid(65534) != 0) return 8; /* there is no such limit for root */
  for (int round = 0; round < 200; ++round) {
    const int result = pose(round % 3 == 0 ? 2 : round % 3 == 1 ? 7 : WORKERS);
    if (result != 0) return result;
  }
  close_model(NULL);
  return 0;
}

int main(int argc, char** argv) {
  program = argv[0];
  if (argc > 1) return limited(argv[1]);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_child_of_fork_poses),
      cmocka_unit_test(too_little_memory_for_all_threads),
      cmocka_unit_test(fewer_threads_than_asked_for),
  };
  return cmocka_run_group_tests(tests, open_model, close_model);
}
