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

/* A mistake of a host: two threads with one scratch. */
typedef struct Rival {
  fb_model* model;
  fb_scratch* scratch;
  float expected[FLOATS];
  int posed, failures;
} Rival;

static void* compete(void* user) {
  Rival* rival = user;
  const float controls[5] = {0.5f, 0, 0.25f, 0, 0};
  for (int round = 0; round < 2000; ++round) {
    float positions[FLOATS];
    const fb_status status = fb_evaluate(rival->model, rival->scratch, controls, positions);
    rival->failures += status != FB_OK && status != FB_ERROR_INVALID_ARGUMENT;
    if (status != FB_OK) continue;
    ++rival->posed;
    rival->failures += memcmp(positions, rival->expected, sizeof positions) != 0;
  }
  return NULL;
}

static void a_shared_scratch_is_refused_not_broken(void** state) {
  (void)state;
  static Rival rivals[2];
  fb_model* model = load_tiny();
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(model, 1, &scratch));
  const float controls[5] = {0.5f, 0, 0.25f, 0, 0};
  pthread_t threads[2];
  for (int t = 0; t < 2; ++t) {
    rivals[t] = (Rival){model, scratch, {0}, 0, 0};
    assert_ok(fb_evaluate(model, scratch, controls, rivals[t].expected));
  }
  for (int t = 0; t < 2; ++t) assert_int_equal(pthread_create(&threads[t], NULL, compete, &rivals[t]), 0);
  for (int t = 0; t < 2; ++t) {
    assert_int_equal(pthread_join(threads[t], NULL), 0);
    assert_int_equal(rivals[t].failures, 0);
  }
  assert_true(rivals[0].posed + rivals[1].posed > 0);
  fb_scratch_destroy(scratch);
  fb_release(model);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_share_a_model),
      cmocka_unit_test(a_shared_scratch_is_refused_not_broken),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
