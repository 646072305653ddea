/* Posing asks nothing of the system: it runs in a child that the kernel ends at any call but read, write and exit. */
#define _GNU_SOURCE
#include "capi_test.h"

#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define POSES 4

static float controls[POSES * 5], positions[POSES * 90], normals[POSES * 90], tangents[POSES * 90], coefficients[64];

static void serial(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  (void)user;
  for (uint32_t i = 0; i < count; ++i) task(context, i, i % workers);
}

/* What the child ends with. */
static int pose(const fb_model* model, fb_scratch* scratch, const fb_batch_desc* desc) {
  for (int round = 0; round < 100; ++round) {
    if (fb_evaluate(model, scratch, controls + 5 * (round % POSES), positions) != FB_OK) return 1;
    if (fb_evaluate_batch(model, scratch, desc) != FB_OK) return 2;
    if (fb_evaluate_coefficients(model, scratch, controls, coefficients) != FB_OK) return 3;
  }
  return 0;
}

static int in_a_child(int calls_the_system) {
  fb_model* model = load_tiny();
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 2, &scratch));
  assert_true(fb_coefficient_count(model) <= 64);
  for (int i = 0; i < POSES * 5; ++i) controls[i] = 0.1f * (float)(i % 9);
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * 5;
  desc.positions = positions;
  desc.position_floats = POSES * 90;
  desc.normals = normals;
  desc.normal_numbers = POSES * 90;
  desc.tangents = tangents;
  desc.tangent_numbers = POSES * 90;
  desc.parallel_for = serial;
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) syscall(SYS_exit, 77);
    const int result = pose(model, scratch, &desc);
    if (calls_the_system) getppid();
    syscall(SYS_exit, result);
  }
  int status = 0;
  assert_int_equal(waitpid(child, &status, 0), child);
  fb_scratch_destroy(scratch);
  fb_release(model);
  return status;
}

static void posing_makes_no_system_call(void** state) {
  (void)state;
  const int status = in_a_child(0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) skip(); /* a kernel without seccomp */
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
  assert_true(WIFSIGNALED(in_a_child(1))); /* the trap works */
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(posing_makes_no_system_call)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
