/* Poses of different faces by one call. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "capi_test.h"

enum { faces = 8, poses = 5 };

typedef struct Face {
  fb_model* model;
  fb_scratch* scratch;
  float *controls, *positions, *normals, *expected, *expected_normals;
  size_t control_floats, floats; /* of all poses */
  fb_batch_desc batch;
} Face;

static Face crowd[faces];
static fb_many_item items[faces];

static int make_face(Face* face, const char* path, int seed) {
  if (fb_load(path, NULL, &face->model) != FB_OK) return -1;
  const size_t width = fb_control_count(face->model);
  face->control_floats = poses * width;
  face->floats = (size_t)poses * 3 * fb_vertex_count(face->model);
  face->controls = malloc(face->control_floats * sizeof(float));
  face->positions = malloc(face->floats * sizeof(float));
  face->normals = malloc(face->floats * sizeof(float));
  face->expected = malloc(face->floats * sizeof(float));
  face->expected_normals = malloc(face->floats * sizeof(float));
  for (size_t i = 0; i < face->control_floats; ++i)
    face->controls[i] = (float)((i * 37 + seed * 11) % 101) / 80 - 0.125f;
  fb_batch_desc_init(&face->batch);
  face->batch.poses = poses;
  face->batch.controls = face->controls;
  face->batch.control_floats = face->control_floats;
  face->batch.positions = face->expected;
  face->batch.normals = face->expected_normals;
  face->batch.position_floats = face->batch.normal_numbers = face->floats;
  /* Half of the crowd has scratches for several poses at a time. */
  if ((seed % 2 ? fb_scratch_create : fb_scratch_create_single)(face->model, 1, &face->scratch) != FB_OK) return -1;
  return fb_evaluate_batch(face->model, face->scratch, &face->batch) == FB_OK ? 0 : -1;
}

static int make_crowd(void** state) {
  static const char* const paths[] = {FB_FIXTURE, FB_CHARACTER, FB_LEVELS, FB_BODY};
  (void)state;
  for (int f = 0; f < faces; ++f)
    if (make_face(&crowd[f], paths[f % 4], f)) return -1;
  return 0;
}

static int free_crowd(void** state) {
  (void)state;
  for (int f = 0; f < faces; ++f) {
    fb_scratch_destroy(crowd[f].scratch);
    fb_release(crowd[f].model);
    free(crowd[f].controls);
    free(crowd[f].positions);
    free(crowd[f].normals);
    free(crowd[f].expected);
    free(crowd[f].expected_normals);
  }
  return 0;
}

/* The whole crowd, whose outputs hold 7 everywhere. */
static fb_many_desc describe(void) {
  for (int f = 0; f < faces; ++f) {
    Face* face = &crowd[f];
    for (size_t i = 0; i < face->floats; ++i) face->positions[i] = face->normals[i] = 7;
    face->batch.positions = face->positions;
    face->batch.normals = face->normals;
    items[f].model = face->model;
    items[f].scratch = face->scratch;
    items[f].batch = &face->batch;
  }
  fb_many_desc desc;
  fb_many_desc_init(&desc);
  desc.items = items;
  desc.item_count = faces;
  return desc;
}

/* The same by one scratch for each kind of face, and no other. */
enum { kinds_of_faces = 4 };
static fb_scratch* shared[kinds_of_faces];
static void make_shared(uint32_t workers) {
  for (int f = 0; f < kinds_of_faces; ++f)
    assert_ok((f % 2 ? fb_scratch_create : fb_scratch_create_single)(crowd[f].model, workers, &shared[f]));
}
static void free_shared(void) {
  for (int f = 0; f < kinds_of_faces; ++f) fb_scratch_destroy(shared[f]);
}
static fb_many_desc describe_shared(void) {
  fb_many_desc desc = describe();
  for (int f = 0; f < faces; ++f) {
    items[f].model = crowd[f % kinds_of_faces].model;
    items[f].scratch = NULL;
  }
  desc.scratches = shared;
  desc.scratch_count = kinds_of_faces;
  return desc;
}

static void assert_posed(int f) {
  assert_memory_equal(crowd[f].positions, crowd[f].expected, crowd[f].floats * sizeof(float));
  assert_memory_equal(crowd[f].normals, crowd[f].expected_normals, crowd[f].floats * sizeof(float));
}

static void assert_untouched(int f) {
  for (size_t i = 0; i < crowd[f].floats; ++i) assert_true(crowd[f].positions[i] == 7 && crowd[f].normals[i] == 7);
}

static void many_faces_equal_each_by_itself(void** state) {
  (void)state;
  for (uint32_t threads = 0; threads <= 3; ++threads) {
    fb_many_desc desc = describe();
    desc.threads = threads;
    uint32_t failed = 77;
    assert_ok(fb_evaluate_many(&desc, &failed));
    assert_int_equal(failed, faces);
    for (int f = 0; f < faces; ++f) assert_posed(f);
  }
}

typedef struct Schedule {
  int calls;
  uint32_t count, workers;
  int left_out; /* tasks that it does not run */
  int again;    /* whether it runs the first one twice */
} Schedule;

/* A host's scheduler, backwards and with all its workers. */
static void backwards(void* user, uint32_t count, uint32_t workers, fb_task task, void* context) {
  Schedule* schedule = user;
  ++schedule->calls;
  schedule->count = count;
  schedule->workers = workers;
  for (uint32_t i = count - (uint32_t)schedule->left_out; i-- > 0;) task(context, i, i % workers);
  if (schedule->again) task(context, 0, 0);
}

static void a_host_may_schedule_items(void** state) {
  (void)state;
  Schedule schedule = {0, 0, 0, 0, 0};
  fb_many_desc desc = describe();
  desc.parallel_for = backwards;
  desc.parallel_user = &schedule;
  assert_ok(fb_evaluate_many(&desc, NULL));
  assert_int_equal(schedule.calls, 1);
  assert_int_equal(schedule.count, faces);
  assert_int_equal(schedule.workers, faces);
  for (int f = 0; f < faces; ++f) assert_posed(f);

  desc.threads = 3;
  assert_ok(fb_evaluate_many(&desc, NULL));
  assert_int_equal(schedule.workers, 3);

  schedule.left_out = 1;
  uint32_t failed = 0;
  assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(failed, faces);
  assert_non_null(strstr(fb_last_error(), "ran 7 items of 8"));
  schedule.left_out = 0;
  schedule.again = 1;
  assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(failed, faces);
  schedule.again = 0;
  assert_ok(fb_evaluate_many(&desc, &failed));
}

static void faces_share_scratches(void** state) {
  (void)state;
  uint64_t expected[faces], clamped[faces], of_kind[kinds_of_faces] = {0};
  for (int f = 0; f < faces; ++f) {
    assert_ok(fb_evaluate_batch(crowd[f].model, crowd[f].scratch, &crowd[f].batch));
    expected[f] = fb_clamped_count(crowd[f].scratch);
    of_kind[f % kinds_of_faces] += expected[f];
  }
  make_shared(3);
  for (uint32_t threads = 0; threads <= 3; ++threads) {
    fb_many_desc desc = describe_shared();
    desc.threads = threads;
    desc.clamped = clamped;
    items[6].scratch = crowd[2].scratch; /* one with a scratch of its own among them */
    assert_ok(fb_evaluate_many(&desc, NULL));
    for (int f = 0; f < faces; ++f) assert_posed(f);
    assert_memory_equal(clamped, expected, sizeof expected);
    for (int f = 0; f < kinds_of_faces; ++f)
      assert_int_equal(fb_clamped_count(shared[f]), of_kind[f] - (f == 2 ? expected[6] : 0));
  }
  free_shared();
}

/* Masks of regions and meshes belong to an item, not to the scratch that several threads share. */
static void items_that_share_a_scratch_have_masks_of_their_own(void** state) {
  (void)state;
  make_shared(2);
  const uint32_t none = 0;
  fb_many_desc desc = describe_shared();
  crowd[1].batch.regions = &none;
  crowd[1].batch.region_count = 0;
  crowd[5].batch.meshes = &none;
  crowd[5].batch.mesh_count = 1;
  const float untouched = 7;
  assert_ok(fb_evaluate_many(&desc, NULL));
  const float* positions = crowd[5].positions;
  size_t written = 0;
  for (size_t i = 0; i < crowd[5].floats; ++i) written += positions[i] != untouched;
  assert_true(written > 0 && written < crowd[5].floats);
  crowd[1].batch.regions = crowd[5].batch.meshes = NULL;
  crowd[5].batch.mesh_count = 0;
  for (int f = 0; f < faces; ++f)
    if (f != 1 && f != 5) assert_posed(f);
  free_shared();
}

static void wrong_shared_scratches_are_refused(void** state) {
  (void)state;
  make_shared(2);
  for (int kind = 0; kind < 5; ++kind) {
    fb_many_desc desc = describe_shared();
    fb_scratch* given[kinds_of_faces + 1] = {shared[0], shared[1], shared[2], shared[3], NULL};
    desc.scratches = given;
    uint32_t failed = 77;
    const char* message = NULL;
    if (kind == 0) desc.scratches = NULL, message = "scratches";
    if (kind == 1) given[2] = NULL, message = "scratch 2 is null";
    if (kind == 2) desc.threads = 3, message = "3 threads, but its scratches have 2 workers";
    if (kind == 3) desc.scratch_count = 2, message = "item 2: scratch";
    if (kind == 4) items[1].model = crowd[1].model, items[1].scratch = shared[1], message = "item 1: scratch is in use";
    assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(fb_last_error(), message));
    assert_int_equal(failed, kind == 3 ? 2 : kind == 4 ? 1 : faces);
    for (int f = 0; f < faces; ++f) assert_untouched(f);
    desc = describe_shared();
    assert_ok(fb_evaluate_many(&desc, NULL)); /* what was taken was given back */
  }
  Schedule schedule = {0, 0, 0, 0, 0};
  fb_many_desc desc = describe_shared();
  desc.parallel_for = backwards;
  desc.parallel_user = &schedule;
  assert_ok(fb_evaluate_many(&desc, NULL));
  assert_int_equal(schedule.workers, 2);
  schedule.again = 1;
  assert_int_equal(fb_evaluate_many(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "ran 9 items of 8"));
  free_shared();
}

/* Counts the bytes that a model and its scratches hold. */
static size_t held_bytes;
static void* allocate_counted(void* user, size_t bytes, size_t alignment) {
  (void)user;
  void* all = malloc(bytes + alignment + sizeof(void*)); /* with where it begins before what is given out */
  if (!all) return NULL;
  held_bytes += bytes;
  const uintptr_t first = ((uintptr_t)all + sizeof(void*) + alignment - 1) & ~(uintptr_t)(alignment - 1);
  memcpy((void*)(first - sizeof(void*)), &all, sizeof(void*));
  return (void*)first;
}
static void release_counted(void* user, void* memory, size_t bytes, size_t alignment) {
  (void)user, (void)alignment;
  void* all = NULL;
  memcpy(&all, (char*)memory - sizeof(void*), sizeof(void*));
  held_bytes -= bytes;
  free(all);
}

/* Instances take the memory of the threads, however many there are, and their outputs. */
static void instances_hold_no_memory(void** state) {
  (void)state;
  enum { instances = 100 };
  fb_load_desc load;
  fb_load_desc_init(&load);
  load.allocator.allocate = allocate_counted;
  load.allocator.release = release_counted;
  fb_model* model = NULL;
  assert_ok(fb_load(FB_LEVELS, &load, &model));
  const size_t floats = 3 * (size_t)fb_vertex_count(model), width = fb_control_count(model);
  float* outputs = malloc(instances * 2 * floats * sizeof *outputs);
  float* controls = calloc(instances * width, sizeof *controls);
  fb_batch_desc* batches = calloc(instances, sizeof *batches);
  fb_many_item* characters = calloc(instances, sizeof *characters);
  for (int i = 0; i < instances; ++i) {
    fb_batch_desc* batch = &batches[i];
    fb_batch_desc_init(batch);
    batch->poses = 1;
    batch->controls = controls + (size_t)i * width;
    batch->control_floats = width;
    batch->positions = outputs + (size_t)i * 2 * floats;
    batch->normals = outputs + (size_t)i * 2 * floats + floats;
    batch->position_floats = batch->normal_numbers = floats;
    batch->lod = 0.5f * (float)(i % 5);
    characters[i].model = model;
    characters[i].batch = batch;
  }
  size_t before = held_bytes;
  fb_scratch *pool = NULL, *own = NULL;
  assert_ok(fb_scratch_create_single(model, 1, &own));
  const size_t scratch_bytes = held_bytes - before;
  assert_true(scratch_bytes > 1000);
  fb_scratch_destroy(own);
  assert_int_equal(held_bytes, before);
  assert_ok(fb_scratch_create_single(model, 2, &pool));
  fb_many_desc desc;
  fb_many_desc_init(&desc);
  desc.items = characters;
  desc.scratches = &pool;
  desc.scratch_count = 1;
  desc.threads = 2;
  for (desc.item_count = 1; desc.item_count <= instances; desc.item_count += 33) {
    assert_ok(fb_evaluate_many(&desc, NULL));
    assert_true(held_bytes - before <= 2 * scratch_bytes);
  }
  fb_scratch_destroy(pool);
  fb_release(model);
  assert_int_equal(held_bytes, 0);
  free(characters);
  free(batches);
  free(controls);
  free(outputs);
}

static void the_scheduler_of_a_batch_is_not_asked(void** state) {
  (void)state;
  Schedule schedule = {0, 0, 0, 0, 0};
  const fb_many_desc desc = describe();
  crowd[1].batch.parallel_for = backwards;
  crowd[1].batch.parallel_user = &schedule;
  crowd[1].batch.threads = 9; /* more than its scratch has */
  assert_ok(fb_evaluate_many(&desc, NULL));
  crowd[1].batch.parallel_for = NULL;
  crowd[1].batch.threads = 0;
  assert_int_equal(schedule.calls, 0);
  assert_posed(1);
}

static void clamping_is_counted_by_item(void** state) {
  (void)state;
  uint64_t expected[faces];
  const fb_many_desc desc = describe();
  for (int f = 0; f < faces; ++f) {
    assert_ok(fb_evaluate_batch(crowd[f].model, crowd[f].scratch, &crowd[f].batch));
    expected[f] = fb_clamped_count(crowd[f].scratch);
  }
  assert_true(expected[0] > 0);
  assert_ok(fb_evaluate_many(&desc, NULL));
  for (int f = 0; f < faces; ++f) assert_int_equal(fb_clamped_count(crowd[f].scratch), expected[f]);
}

static void items_that_fail_are_named_and_the_others_posed(void** state) {
  (void)state;
  const float saved = crowd[5].controls[1];
  for (uint32_t threads = 1; threads <= 2; ++threads) {
    fb_many_desc desc = describe();
    desc.threads = threads;
    crowd[5].controls[1] = NAN;
    crowd[6].batch.position_floats -= 1;
    uint32_t failed = 77;
    assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_NOT_FINITE);
    crowd[5].controls[1] = saved;
    crowd[6].batch.position_floats += 1;
    assert_int_equal(failed, 5);
    assert_memory_equal(fb_last_error(), "item 5: ", 8);
    assert_non_null(strstr(fb_last_error(), "pose 0"));
    for (int f = 0; f < faces; ++f)
      if (f == 5 || f == 6)
        assert_untouched(f);
      else
        assert_posed(f);
    assert_ok(fb_evaluate_many(&desc, NULL)); /* the scratches were given back */
  }
}

static void items_that_lack_something_are_refused_before_anything_is_written(void** state) {
  (void)state;
  enum { kinds = 6 };
  fb_batch_desc unfilled;
  memset(&unfilled, 0, sizeof unfilled);
  for (int kind = 0; kind < kinds; ++kind) {
    const fb_many_desc desc = describe();
    if (kind == 0) items[3].model = NULL;
    if (kind == 1) items[3].scratch = NULL;
    if (kind == 2) items[3].batch = NULL;
    if (kind == 3) items[3].batch = &unfilled;
    if (kind == 4) items[3].model = crowd[2].model;
    if (kind == 5) items[3] = items[0];
    uint32_t failed = 77;
    assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_INVALID_ARGUMENT);
    assert_int_equal(failed, 3);
    assert_memory_equal(fb_last_error(), "item 3: ", 8);
    for (int f = 0; f < faces; ++f) assert_untouched(f);
    const fb_many_desc good = describe();
    assert_ok(fb_evaluate_many(&good, NULL));
  }
}

static void wrong_lists_are_refused(void** state) {
  (void)state;
  assert_int_equal(fb_evaluate_many(NULL, NULL), FB_ERROR_INVALID_ARGUMENT);
  fb_many_desc desc;
  memset(&desc, 0, sizeof desc);
  assert_int_equal(fb_evaluate_many(&desc, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "fb_many_desc_init"));
  fb_many_desc_init(&desc);
  uint32_t failed = 77;
  assert_ok(fb_evaluate_many(&desc, &failed)); /* of no faces */
  assert_int_equal(failed, 0);
  desc.item_count = 1;
  assert_int_equal(fb_evaluate_many(&desc, &failed), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "items"));
  assert_int_equal(failed, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(many_faces_equal_each_by_itself),
      cmocka_unit_test(a_host_may_schedule_items),
      cmocka_unit_test(faces_share_scratches),
      cmocka_unit_test(items_that_share_a_scratch_have_masks_of_their_own),
      cmocka_unit_test(wrong_shared_scratches_are_refused),
      cmocka_unit_test(instances_hold_no_memory),
      cmocka_unit_test(the_scheduler_of_a_batch_is_not_asked),
      cmocka_unit_test(clamping_is_counted_by_item),
      cmocka_unit_test(items_that_fail_are_named_and_the_others_posed),
      cmocka_unit_test(items_that_lack_something_are_refused_before_anything_is_written),
      cmocka_unit_test(wrong_lists_are_refused),
  };
  return cmocka_run_group_tests(tests, make_crowd, free_crowd);
}
