/* One model, several threads: references counted, poses evaluated, errors kept apart. */
#include "capi_test.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#define THREADS 4
#define ROUNDS 200
#define FLOATS 90

typedef struct Job {
  fb_model* model; /* with a reference of its own */
  int number, failures;
} Job;

static void* work(void* user) {
  Job* job = user;
  float controls[5] = {0, 0, 0.25f, 0, 0}, first[FLOATS], positions[FLOATS];
  controls[0] = 0.2f * (float)(job->number + 1);
  for (int round = 0; round < ROUNDS; ++round) {
    fb_scratch* scratch = NULL;
    fb_retain(job->model);
    job->failures += fb_scratch_create(job->model, 1, &scratch) != FB_OK;
    job->failures += fb_evaluate(job->model, scratch, controls, round == 0 ? first : positions) != FB_OK;
    if (round > 0) job->failures += memcmp(positions, first, sizeof first) != 0;
    char name[32];
    uint32_t index;
    snprintf(name, sizeof name, "nobody%d", job->number);
    job->failures += fb_find_control(job->model, name, &index) != FB_ERROR_NOT_FOUND;
    job->failures += strstr(fb_last_error(), name) == NULL;
    fb_scratch_destroy(scratch);
    fb_release(job->model);
  }
  fb_release(job->model);
  return NULL;
}

static void threads_share_a_model(void** state) {
  (void)state;
  fb_model* model = load_tiny();
  Job jobs[THREADS];
  pthread_t threads[THREADS];
  for (int t = 0; t < THREADS; ++t) {
    fb_retain(model);
    jobs[t] = (Job){model, t, 0};
    assert_int_equal(pthread_create(&threads[t], NULL, work, &jobs[t]), 0);
  }
  fb_release(model); /* whoever ends last frees it */
  for (int t = 0; t < THREADS; ++t) {
    assert_int_equal(pthread_join(threads[t], NULL), 0);
    assert_int_equal(jobs[t].failures, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(threads_share_a_model)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
