#include "bake/rig/rig_evaluator.h"

#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <map>
#include <thread>

#include "bake_test_support.h"
#include "base/file.h"
#include "base/random.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_rig_evaluator {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 4, side = 6, size = 3 * side * side;

void formula(const float* c, std::span<float> points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] += std::sin(float(i) * c[0]) + c[1] * c[2] * float(i % 7) - c[3];
}

std::vector<float> random_poses(std::size_t count, std::uint64_t seed = 5) {
  Random random(seed);
  std::vector<float> poses(count * width);
  for (float& value : poses) value = random.uniform(-1.0f, 1.0f);
  return poses;
}

// Counts what it evaluates, pose by pose; takes a millisecond a pose if it is slow.
struct CountingRig : MemorySource {
  explicit CountingRig(bool slow = false) : MemorySource(width, side, formula, true), slow(slow) {}
  bool thread_safe() const override { return false; }
  void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
    if (slow) std::this_thread::sleep_for(std::chrono::milliseconds(count));
    MemorySource::evaluate(poses, count, points);
    for (std::size_t i = 0; i < count; ++i) ++times[{poses.begin() + width * i, poses.begin() + width * (i + 1)}];
  }
  std::size_t evaluated() const {
    std::size_t sum = 0;
    for (const auto& [pose, count] : times) sum += count;
    return sum;
  }
  std::map<std::vector<float>, std::size_t> times;
  bool slow;
};

std::vector<float> truth(std::span<const float> poses) {
  MemorySource rig(width, side, formula, true);
  std::vector<float> points(poses.size() / width * size);
  rig.evaluate(poses, poses.size() / width, points);
  return points;
}

// Fails with PoseError on poses whose first control is above a limit, so many times each.
struct FlakyRig final : CountingRig {
  void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
    for (std::size_t i = 0; i < count; ++i)
      if (poses[width * i] > 0.9f && failures[poses[width * i]]++ < most) throw PoseError(Status::rig, i, "no licence");
    CountingRig::evaluate(poses, count, points);
  }
  std::map<float, int> failures;
  int most = 1;
};

}  // namespace

TEST_CASE("points come in the order of the poses, whatever threads, pieces and cache") {
  const std::vector<float> poses = random_poses(1003), expected = truth(poses);
  for (const int threads : {1, 2, 5}) {
    MemorySource rig(width, side, formula, true);
    RigEvaluator evaluator(rig, {.threads = threads});
    std::vector<float> points(expected.size());
    evaluator.evaluate(poses, 1003, points);
    CHECK(points == expected);
    std::fill(points.begin(), points.end(), NAN);
    EvaluationStage stage(silent_progress(), Phase::sampling, "all", 1003);
    evaluator.evaluate_each(
        1003, stage,
        [&](std::size_t i, std::span<float> pose) {
          CHECK(std::equal(pose.begin(), pose.end(), rig.schema().rest_pose().begin()));
          std::copy_n(poses.begin() + width * i, width, pose.begin());
        },
        [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
          for (std::size_t k = 0; k < size; ++k) points[i * size + k] = displacement[k] + rig.rest().points[k];
        });
    for (std::size_t k = 0; k < points.size(); ++k) REQUIRE(points[k] == doctest::Approx(expected[k]).epsilon(1e-5));
    CHECK(evaluator.requested() == 1003);
    CHECK(evaluator.evaluated() == 2006);
  }
}

TEST_CASE("a backend evaluates whole blocks, and the source nothing") {
  struct Backend final : EvaluationBackend {
    void evaluate_block(const EvaluationBlock& block) override {
      blocks.push_back(block.count);
      std::ranges::copy(truth(block.controls), block.points.begin());
    }
    std::size_t least_poses() const override { return 7; }
    std::vector<std::size_t> blocks;
  };
  CountingRig rig;
  auto backend = std::make_unique<Backend>();
  const std::vector<std::size_t>& blocks = backend->blocks;
  RigEvaluator evaluator(rig, std::move(backend));
  const std::vector<float> poses = random_poses(300);
  std::vector<float> points(300 * size);
  evaluator.evaluate(poses, 300, points);
  CHECK(points == truth(poses));
  CHECK(blocks == std::vector<std::size_t>{300});
  CHECK(rig.evaluated() == 0);
  CHECK(contains(failure(Status::invalid_argument, [&] { evaluator.evaluate(poses, 299, points); }), "299 poses need"));
}

TEST_CASE("a block has the poses that a rig prefers, even if they take long, and more of a quick one") {
  struct ManyRig final : CountingRig {
    using CountingRig::CountingRig;
    std::size_t preferred_block() const override { return 12; }
    void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
      if (slow) std::this_thread::sleep_for(std::chrono::milliseconds(30 * count));
      calls.push_back(count);
      MemorySource::evaluate(poses, count, points);
    }
    std::vector<std::size_t> calls;
  };
  const std::vector<float> poses = random_poses(60);
  std::vector<float> points(60 * size);
  Questions progress;
  ManyRig rig(true);
  RigEvaluator(rig, {.progress = &progress})
      .evaluate(std::span(poses).first(30 * width), 30, std::span(points).first(30 * size));
  CHECK(rig.calls == std::vector<std::size_t>{12, 12, 6});
  CHECK(progress.asked >= 3);
  ManyRig quick;
  RigEvaluator(quick, {.progress = &progress}).evaluate(poses, 60, points);
  CHECK(quick.calls == std::vector<std::size_t>{12, 12, 12, 12, 12});
  CHECK(points == truth(poses));
}

TEST_CASE("what was evaluated of a call that fails is kept") {
  const Folder folder;
  FlakyRig rig;
  rig.slow = true;
  rig.most = 2;
  std::vector<float> poses = random_poses(16, 8), points(16 * size);
  for (std::size_t i = 0; i < 16; ++i) poses[i * width] = i == 4 ? 0.95f : 0.01f * float(i);
  {
    RigEvaluator evaluator(rig, {}, folder / "evaluations");
    failure(Status::rig, [&] { evaluator.evaluate_cached(poses, 16, points); });
  }
  const std::size_t before = rig.evaluated();
  CHECK(before == 14);  // all but the piece of two poses that failed
  RigEvaluator evaluator(rig, {}, folder / "evaluations");
  evaluator.evaluate_cached(poses, 16, points);
  CHECK(points == truth(poses));
  CHECK(rig.evaluated() == before + 2);
}

TEST_CASE("budgets count different poses, nest, and refuse what would pass them") {
  CountingRig rig;
  rig.add_clip("line", ClipKind::shot, Split::train, 12, 0.5f, 3);
  RigEvaluator evaluator(rig);
  CHECK(evaluator.remaining() == UINT64_MAX);
  const std::vector<float> poses = random_poses(60);
  std::vector<float> points(60 * size);
  const auto evaluate = [&](std::size_t first, std::size_t count) {
    evaluator.evaluate(std::span(poses).subspan(first * width, count * width), count,
                       std::span(points).first(count * size));
  };
  evaluate(0, 5);
  const EvaluationBudget budget(evaluator, 50);
  evaluate(5, 40);
  CHECK(evaluator.remaining() == 10);
  CHECK(budget.requested() == 40);
  evaluate(0, 45);  // poses that are known already
  CHECK(evaluator.remaining() == 10);
  CHECK(contains(failure(Status::invalid_argument, [&] { evaluate(45, 11); }), "rig budget of 50"));
  CHECK(budget.requested() == 40);
  {
    const EvaluationBudget inner(evaluator, 4), counter(evaluator);
    CHECK(evaluator.remaining() == 4);
    failure(Status::invalid_argument, [&] { evaluate(45, 5); });
    evaluate(42, 6);
    CHECK(counter.requested() == 3);
    CHECK(counter.evaluated() == 6);
  }
  evaluator.read(0, 0, 12, std::span(points).first(12 * size));
  CHECK(budget.requested() == 43);  // frames of the rig's own clips are counted apart
  evaluate(48, 7);
  CHECK(evaluator.remaining() == 0);
  CHECK(evaluator.evaluated() == 5 + 40 + 45 + 6 + 12 + 7);
  CHECK(rig.evaluated() == evaluator.evaluated());
}

TEST_CASE("the cache of a slow rig is keyed by pose and outlives the evaluator") {
  const Folder folder;
  const std::filesystem::path cache = folder / "work" / "evaluations";
  const std::vector<float> poses = random_poses(60), expected = truth(poses);
  std::vector<float> points(60 * size);
  {
    CountingRig rig(true);
    RigEvaluator evaluator(rig, {}, cache);
    const auto some = std::span(poses).subspan(20 * width, 25 * width);
    evaluator.evaluate_cached(some, 25, std::span(points).first(25 * size));
    CHECK(rig.evaluated() == 25);
    evaluator.evaluate_cached(some, 25, std::span(points).first(25 * size));
    CHECK(rig.evaluated() == 25);
    CHECK(evaluator.evaluated() == 25);
    CHECK(evaluator.requested() == 25);
    evaluator.evaluate(some, 25, std::span(points).first(25 * size));  // always evaluates
    CHECK(rig.evaluated() == 50);
  }
  CountingRig rig(true);
  RigEvaluator evaluator(rig, {}, cache);
  evaluator.evaluate_cached(poses, 60, points);
  CHECK(points == expected);
  CHECK(rig.evaluated() == 35);
  // Equal poses of one call are evaluated once, and so in another order.
  std::vector<float> twice = random_poses(10, 6);
  twice.insert(twice.end(), twice.begin(), twice.end());
  twice.insert(twice.begin(), poses.begin(), poses.begin() + width);
  std::vector<float> found(21 * size);
  evaluator.evaluate_cached(twice, 21, found);
  CHECK(found == truth(twice));
  CHECK(rig.evaluated() == 45);
  for (const auto& [pose, count] : rig.times) CHECK(count == 1);
}

TEST_CASE("frames of clips of a slow rig are kept too, and count against no budget") {
  const Folder folder;
  const std::vector<float> poses = random_poses(20);
  std::vector<float> points(20 * size);
  CountingRig rig(true);
  RigEvaluator evaluator(rig, {}, folder / "evaluations");
  const EvaluationBudget budget(evaluator, 1);
  for (int i = 0; i < 2; ++i) evaluator.evaluate_apart_cached(poses, 20, points);
  CHECK(points == truth(poses));
  CHECK(rig.evaluated() == 20);
  CHECK(budget.requested() == 0);
}

TEST_CASE("frames read of clips of a slow rig are kept, by any number of threads") {
  struct SlowRig final : MemorySource {
    SlowRig() : MemorySource(width, side, formula, true) { add_clip("shot", ClipKind::shot, Split::test, 64, 1, 3); }
    void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
      std::this_thread::sleep_for(std::chrono::milliseconds(count));
      MemorySource::evaluate(poses, count, points);
    }
  };
  const Folder folder;
  SlowRig rig;
  for (const std::uint64_t evaluated : {64, 0}) {
    RigEvaluator evaluator(rig, {}, folder / "evaluations");
    std::vector<float> points(64 * size);
    parallel_for({.threads = 4}, 8, [&](std::size_t i, std::size_t) {
      evaluator.read(0, 8 * i, 8, std::span(points).subspan(8 * i * size, 8 * size));
    });
    CHECK(points == truth(rig.clips()[0].controls));
    CHECK(evaluator.evaluated() == evaluated);
  }
}

TEST_CASE("beyond its limit nothing is kept but what a budget counts, and results are the same") {
  const std::vector<float> poses = random_poses(60), frames = random_poses(30, 6);
  std::vector<float> points(60 * size), shot(30 * size);
  for (const bool keep_requested : {false, true}) {
    const Folder folder;
    const auto evaluated = [&] {
      CountingRig rig(true);
      RigEvaluator evaluator(rig, {}, folder / "evaluations");
      evaluator.set_cache_limit({10'000, keep_requested});
      evaluator.evaluate_apart_cached(frames, 30, shot);
      const EvaluationBudget budget(evaluator, 60);
      evaluator.evaluate_cached(poses, 60, points);
      CHECK(points == truth(poses));
      CHECK(shot == truth(frames));
      CHECK(budget.requested() == 60);
      return rig.evaluated();
    };
    CHECK(evaluated() == 90);
    const std::uintmax_t bytes = std::filesystem::file_size(folder / "evaluations");
    const std::size_t again = evaluated();
    CHECK(std::filesystem::file_size(folder / "evaluations") == bytes);
    CHECK(again > (keep_requested ? 0 : 60));
    CHECK(again < (keep_requested ? 30 : 90));
    CHECK((bytes <= 10'000) == !keep_requested);
  }
}

TEST_CASE("a cache that is a pipe is refused at once, not waited for") {
  const Folder folder;
  const std::filesystem::path pipe = folder / "evaluations";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CountingRig rig(true);
  CHECK(contains(failure(Status::io, [&] { RigEvaluator(rig, {}, pipe); }), "is no regular file"));
}

TEST_CASE("records that are cut off or damaged are evaluated anew, and caches of another rig are refused") {
  const Folder folder;
  const std::filesystem::path cache = folder / "evaluations";
  const std::vector<float> poses = random_poses(8), expected = truth(poses);
  const auto evaluated = [&](CountingRig rig) {
    RigEvaluator evaluator(rig, {}, cache);
    std::vector<float> points(8 * size);
    evaluator.evaluate_cached(poses, 8, points);
    CHECK(points == expected);
    return rig.evaluated();
  };
  CHECK(evaluated(CountingRig(true)) == 8);
  CHECK(evaluated(CountingRig(true)) == 0);
  const std::vector<std::byte> whole = read_file(cache);
  const std::size_t header = whole.size() - 8 * (16 + 4 * (width + size));
  for (std::size_t at = 0; at < whole.size(); at += 97) {
    std::vector<std::byte> damaged = whole;
    damaged[at] ^= std::byte{4};
    write_file(cache, damaged);
    CHECK(evaluated(CountingRig(true)) == (at < header ? 8 : 1));
    CHECK(evaluated(CountingRig(true)) == 0);
    write_file(cache, std::span(whole).first(at));
    CHECK(evaluated(CountingRig(true)) >= 1);
    CHECK(evaluated(CountingRig(true)) == 0);
  }
  CountingRig other(true);
  other.edit_schema().controls[0].maximum = 2;
  CHECK(contains(
      failure(Status::invalid_argument, [&] { evaluated(other); }),
      "holds evaluations of another rig: the range of the control \"control0\" was -1 to 1, at rest 0 and is -1 "
      "to 2, at rest 0"));
  CHECK(evaluated(CountingRig(true)) == 0);
}

TEST_CASE("a slow rig is called with few poses at a time, so that Ctrl-C waits for a few, and loses none before them") {
  struct SlowRig final : CountingRig {
    void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
      std::this_thread::sleep_for(std::chrono::milliseconds(40 * count));
      CountingRig::evaluate(poses, count, points);
    }
  };
  const Folder folder;
  const std::vector<float> poses = random_poses(60), expected = truth(poses);
  std::vector<float> points(60 * size);
  Questions progress;
  progress.stop_at = 8;
  SlowRig first;
  RigEvaluator stopped(first, {.threads = 1, .progress = &progress}, folder / "evaluations");
  failure(Status::interrupted, [&] { stopped.evaluate_cached(poses, 60, points); });
  CHECK(first.evaluated() <= 1 + 8 * 5);  // 0.2 s take 5 poses at most
  progress.stop_at = 1 << 30;
  SlowRig second;
  RigEvaluator goes_on(second, {.threads = 1, .progress = &progress}, folder / "evaluations");
  goes_on.evaluate_cached(poses, 60, points);
  CHECK(points == expected);
  CHECK(second.evaluated() >= 60 - first.evaluated());
  CHECK(second.evaluated() <= 65 - first.evaluated());  // the call that was interrupted is lost
  CHECK(progress.asked >= 8 + 19 / 5);
}

TEST_CASE("a quick rig is evaluated again rather than read from a file") {
  const Folder folder;
  CountingRig rig;
  RigEvaluator evaluator(rig, {}, folder / "evaluations");
  const std::vector<float> poses = random_poses(100);
  std::vector<float> points(100 * size);
  for (int i = 0; i < 2; ++i) evaluator.evaluate_cached(poses, 100, points);
  CHECK(rig.evaluated() == 200);
  CHECK_FALSE(std::filesystem::exists(folder / "evaluations"));
}

TEST_CASE("a pose that takes longer to keep than to evaluate is evaluated again") {
  constexpr std::size_t many = 700, poses = 3;  // 490,000 vertices: 6 MB a pose, in little more than a millisecond
  struct LargeRig final : MemorySource {
    LargeRig()
        : MemorySource(
              width, many, [](const float* c, std::span<float> points) { points[0] += c[0]; }, true) {}
    void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
      std::this_thread::sleep_for(std::chrono::milliseconds(count));
      MemorySource::evaluate(controls, count, points);
      evaluated += count;
    }
    std::atomic<std::size_t> evaluated = 0;
  };
  const Folder folder;
  LargeRig rig;
  RigEvaluator evaluator(rig, {}, folder / "evaluations");
  const std::vector<float> controls = random_poses(poses);
  std::vector<float> first(poses * 3 * many * many), second(first.size());
  evaluator.evaluate_cached(controls, poses, first);
  evaluator.evaluate_cached(controls, poses, second);
  CHECK(first == second);
  CHECK(rig.evaluated == 2 * poses);
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("a full disk keeps no more evaluations, and ends nothing") {
  const Folder folder;
  CountingRig rig(true);
  test::Notes notes;
  RigEvaluator evaluator(rig, {.threads = 1, .progress = &notes}, folder / "evaluations");
  const std::vector<float> poses = random_poses(60);
  std::vector<float> points(60 * size);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small = {8192, before.rlim_max};
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  for (int i = 0; i < 2; ++i) {
    std::ranges::fill(points, 0.0f);
    CHECK_NOTHROW(evaluator.evaluate_cached(poses, 60, points));
    CHECK(points == truth(poses));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal_before);
  CHECK(notes.all.find("evaluations: the rig's evaluations cannot be written: File too large. The bake goes on") !=
        std::string::npos);
  CHECK(rig.evaluated() < 120);  // what had been written before is kept

  CountingRig again(true);  // and of use to the next bake
  RigEvaluator next(again, {}, folder / "evaluations");
  next.evaluate_cached(poses, 60, points);
  CHECK(points == truth(poses));
  CHECK(again.evaluated() < 60);
}

TEST_CASE("a block in which poses fail is evaluated again, and a pose that fails twice is named") {
  std::vector<float> poses(200 * width);
  for (const std::size_t bad : {70u, 150u}) poses[bad * width] = 0.9f + float(bad) / 2000;
  std::vector<float> points(200 * size);
  FlakyRig once;
  RigEvaluator evaluator(once);
  evaluator.evaluate(poses, 200, points);
  CHECK(points == truth(poses));
  CHECK(evaluator.requested() == 2);    // different ones besides rest
  CHECK(evaluator.evaluated() == 250);  // in pieces of 25, of which two failed
  FlakyRig twice;
  twice.most = 2;
  RigEvaluator failing(twice);
  CHECK(failure(Status::rig, [&] { failing.evaluate(poses, 200, points); }) == "pose 70: no licence");
  EvaluationStage stage(silent_progress(), Phase::sampling, "all", 200);
  FlakyRig named;
  named.most = 2;
  RigEvaluator by_name(named);
  const auto fill = [&](std::size_t i, std::span<float> pose) { std::copy_n(&poses[i * width], width, pose.begin()); };
  CHECK(failure(Status::rig, [&] { by_name.evaluate_each(200, stage, fill, [](auto, auto, auto) {}); }) ==
        "control \"control0\" at 0.935: no licence");
}

TEST_CASE("the number of a failing pose is that within the call where others come from the cache") {
  const Folder folder;
  FlakyRig rig;
  rig.slow = true;
  rig.most = 2;
  RigEvaluator evaluator(rig, {}, folder / "evaluations");
  std::vector<float> poses = random_poses(20, 8), points(20 * size);
  for (std::size_t i = 0; i < 20; ++i) poses[i * width] = 0.01f * float(i);
  evaluator.evaluate_cached(std::span(poses).first(10 * width), 10, std::span(points).first(10 * size));
  poses[15 * width] = 0.95f;
  CHECK(failure(Status::rig, [&] { evaluator.evaluate_cached(poses, 20, points); }) == "pose 15: no licence");
}

TEST_CASE("poses are described by the controls that are away from rest") {
  const RigSchema schema = CountingRig().schema();
  CHECK(describe_pose(schema, std::vector<float>{0, 0.5f, 0, -1}) == "\"control1\" at 0.5, \"control3\" at -1");
  CHECK(describe_pose(schema, std::vector<float>{1, 1, 1, 1}) ==
        "\"control0\" at 1, \"control1\" at 1, \"control2\" at 1 and 1 more");
}

}  // namespace test_rig_evaluator
