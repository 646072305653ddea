/* A host that evaluates the poses of a source itself: blocks, and a source that is spread. */
#include "authoring_fixture.h"

#define assert_at(type, field, offset) assert_int_equal(offsetof(type, field), offset)

static void layout_of_blocks(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_pose_block), 88);
  assert_at(fb_pose_block, threads, 4);
  assert_at(fb_pose_block, poses, 8);
  assert_at(fb_pose_block, controls, 16);
  assert_at(fb_pose_block, positions, 24);
  assert_at(fb_pose_block, channels, 32);
  assert_at(fb_pose_block, answered, 40);
  assert_at(fb_pose_block, evaluated, 48);
  assert_at(fb_pose_block, failed, 56);
  assert_at(fb_pose_block, callbacks, 64);

  assert_int_equal(sizeof(fb_spreader), 32);
  assert_at(fb_spreader, preferred_block, 4);
  assert_at(fb_spreader, user, 8);
  assert_at(fb_spreader, evaluate, 16);
  assert_at(fb_spreader, close, 24);
}

enum { poses = 5 };

typedef struct Block {
  fb_pose_block block;
  float values[poses * controls], positions[poses * floats];
  uint8_t answered[poses];
} Block;

/* At rest but for the third pose, in which the first control is at the end of its range. */
static void make_block(const fb_source* source, Block* made) {
  memset(made, 0, sizeof *made);
  for (uint32_t i = 0; i < poses * controls; ++i) {
    fb_control control;
    fb_control_init(&control);
    assert_ok(fb_source_control_at(source, i % controls, &control));
    made->values[i] = i == 2 * controls ? control.maximum : control.rest;
  }
  fb_pose_block_init(&made->block);
  made->block.poses = poses;
  made->block.controls = made->values;
  made->block.positions = made->positions;
  made->block.answered = made->answered;
}

static void a_block_is_what_a_source_evaluates(void** state) {
  (void)state;
  const fb_source_info info = describe(toy);
  assert_int_equal(info.channel_count, 0);
  assert_true(*info.identity);
  Block made;
  make_block(toy, &made);
  assert_ok(fb_source_evaluate_block(toy, &made.block));
  assert_int_equal(made.block.evaluated, poses);
  assert_int_equal(made.block.failed, poses);
  float expected[poses * floats];
  assert_ok(fb_source_evaluate(toy, made.values, poses, 1, expected, poses * floats));
  assert_memory_equal(made.positions, expected, sizeof expected);
  for (int p = 0; p < poses; ++p) assert_int_equal(made.answered[p], 1);

  made.values[3 * controls] = 100;
  assert_int_equal(fb_source_evaluate_block(toy, &made.block), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(made.block.failed, 3);
  made.block.controls = NULL;
  assert_refused(fb_source_evaluate_block(toy, &made.block), FB_ERROR_INVALID_ARGUMENT, "controls");
  assert_refused(fb_source_evaluate_block(toy, NULL), FB_ERROR_INVALID_ARGUMENT, "block");
  fb_pose_block unfilled;
  memset(&unfilled, 0, sizeof unfilled);
  assert_refused(fb_source_evaluate_block(toy, &unfilled), FB_ERROR_INVALID_ARGUMENT, "fb_pose_block_init");
}

static void a_block_is_interrupted(void** state) {
  (void)state;
  Seen seen;
  Block made;
  make_block(toy, &made);
  made.block.callbacks = watch(&seen);
  seen.stop_after = 1;
  assert_int_equal(fb_source_evaluate_block(toy, &made.block), FB_ERROR_INTERRUPTED);
  for (int p = 0; p < poses; ++p) assert_int_equal(made.answered[p], 0);
}

/* A host that counts, and evaluates by the source below; or fails on a pose, or stops. */
typedef struct Host {
  fb_source* below;
  int blocks, closed, asked_to_stop;
  uint64_t poses, fail_at; /* fail_at: the pose of the next block that fails; UINT64_MAX: none */
} Host;

static fb_status evaluate_for_host(void* user, fb_pose_block* block, char* message, uint32_t message_size) {
  Host* host = user;
  ++host->blocks;
  host->poses += block->poses;
  if (block->callbacks.progress && block->callbacks.progress(block->callbacks.user, "far away", 0, 0))
    ++host->asked_to_stop;
  if (host->fail_at < block->poses) {
    block->failed = host->fail_at;
    snprintf(message, message_size, "a machine far away has no licence");
    return FB_ERROR_RIG;
  }
  return fb_source_evaluate_block(host->below, block);
}

static void close_host(void* user) {
  ++((Host*)user)->closed;
}

static fb_source* spread(Host* host) {
  Seen seen;
  memset(host, 0, sizeof *host);
  host->below = open_paths(&toy_path, 1, &seen);
  host->fail_at = UINT64_MAX;
  fb_spreader spreader;
  fb_spreader_init(&spreader);
  spreader.user = host;
  spreader.evaluate = evaluate_for_host;
  spreader.close = close_host;
  spreader.preferred_block = 64;
  fb_source* source = NULL;
  assert_ok(fb_source_spread(host->below, &spreader, &source));
  return source;
}

static void* bytes_of(const char* path, long* size) {
  FILE* file = fopen(path, "rb");
  assert_non_null(file);
  fseek(file, 0, SEEK_END);
  *size = ftell(file);
  rewind(file);
  void* bytes = malloc((size_t)*size);
  assert_int_equal(fread(bytes, 1, (size_t)*size, file), *size);
  fclose(file);
  return bytes;
}

static void a_spread_source_bakes_the_same_archive(void** state) {
  (void)state;
  Host host;
  fb_source* source = spread(&host);
  const fb_source_info info = describe(source), of_toy = describe(toy);
  assert_string_equal(info.identity, of_toy.identity);
  assert_int_equal(info.preferred_block, 64);
  assert_int_equal(info.flags, FB_SOURCE_LIVE);
  Seen seen;
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  desc.source = source;
  desc.archive = in_folder("spread.fbk");
  desc.recipe = "linear";
  desc.poses = 200;
  desc.threads = 2;
  desc.callbacks = watch(&seen);
  assert_ok(fb_bake(&desc, NULL));
  assert_true(host.poses > 200);
  long alone_size, spread_size;
  void *alone = bytes_of(in_folder("toy.fbk"), &alone_size), *far = bytes_of(in_folder("spread.fbk"), &spread_size);
  assert_int_equal(alone_size, spread_size);
  assert_memory_equal(alone, far, (size_t)alone_size);
  free(alone);
  free(far);
  assert_int_equal(host.closed, 0);
  fb_source_close(source);
  assert_int_equal(host.closed, 1);
}

static void what_fails_far_away_is_told(void** state) {
  (void)state;
  Host host;
  fb_source* source = spread(&host);
  Block made;
  make_block(source, &made);
  host.fail_at = 2;
  float positions[poses * floats];
  assert_refused(fb_source_evaluate(source, made.values, poses, 1, positions, poses * floats), FB_ERROR_RIG,
                 "pose 2: a machine far away has no licence");
  Seen seen;
  made.block.callbacks = watch(&seen);
  seen.stop_after = 1;
  host.fail_at = UINT64_MAX;
  assert_int_equal(fb_source_evaluate_block(source, &made.block), FB_ERROR_INTERRUPTED);
  fb_source_close(source);
}

static void what_cannot_be_spread_is_refused(void** state) {
  (void)state;
  fb_spreader spreader;
  fb_spreader_init(&spreader);
  fb_source* source = NULL;
  assert_refused(fb_source_spread(toy, &spreader, &source), FB_ERROR_INVALID_ARGUMENT, "evaluate is null");
  spreader.evaluate = evaluate_for_host;
  assert_refused(fb_source_spread(NULL, &spreader, &source), FB_ERROR_INVALID_ARGUMENT, "source");
  assert_refused(fb_source_spread(toy, NULL, &source), FB_ERROR_INVALID_ARGUMENT, "spreader");

  fb_sample_desc desc;
  fb_sample_desc_init(&desc);
  desc.source = toy;
  desc.directory = in_folder("recorded");
  desc.poses = 50;
  assert_ok(fb_sample(&desc, NULL));
  Seen seen;
  const char* const recorded_path = in_folder("recorded");
  fb_source* recorded = open_paths(&recorded_path, 1, &seen);
  assert_string_equal(describe(recorded).identity, "");
  assert_refused(fb_source_spread(recorded, &spreader, &source), FB_ERROR_INVALID_ARGUMENT, "is a recording");
  Block made;
  make_block(recorded, &made);
  assert_refused(fb_source_evaluate_block(recorded, &made.block), FB_ERROR_INVALID_ARGUMENT, "is a recording");
  fb_source_close(recorded);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(layout_of_blocks),
      cmocka_unit_test(a_block_is_what_a_source_evaluates),
      cmocka_unit_test(a_block_is_interrupted),
      cmocka_unit_test(a_spread_source_bakes_the_same_archive),
      cmocka_unit_test(what_fails_far_away_is_told),
      cmocka_unit_test(what_cannot_be_spread_is_refused),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
