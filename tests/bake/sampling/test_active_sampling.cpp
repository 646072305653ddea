#include "bake/dataset/open_source.h"
#include "bake/sampling/active_sampling.h"
#include "bake/sampling/control_responses.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/rig/pose_set.h"
#include "bake_test_support.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_active_sampling {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 30;

MemorySource live_face() {
  return MemorySource(
      width, 6,
      [](const float* c, std::span<float> points) {
        for (std::size_t k = 0; k < width; ++k) points[3 * k] += c[k] * (1 + 0.2f * c[(k + 1) % width]);
      },
      true);
}

// Far along with control 0 is what this ensemble knows nothing about.
std::vector<float> unsure_of_0(std::span<const float> controls, std::size_t count) {
  std::vector<float> scores;
  for (std::size_t i = 0; i < count; ++i) scores.push_back(std::abs(controls[i * width]));
  return scores;
}

std::vector<float> random_pool(std::size_t poses) {
  MemorySource rig = live_face();
  rig.add_clip("pool", ClipKind::dense, Split::train, poses, 0.8f, 5);
  return rig.clips()[0].controls;
}

struct StopAt final : QuietProgress {
  void begin(Phase, std::string_view, std::uint64_t) override { ++stages; }
  bool cancelled() const override { return stages >= stop_at; }
  std::size_t stages = 0, stop_at = SIZE_MAX;
};

}  // namespace

TEST_CASE("the poses of most variance are selected, and some others") {
  const MemorySource rig = live_face();
  const std::vector<float> pool = random_pool(2500);
  const std::vector<float> scores = unsure_of_0(pool, 2500);
  const auto mean_of = [&](const std::vector<std::uint32_t>& poses) {
    double sum = 0;
    for (const std::uint32_t pose : poses) sum += scores[pose];
    return sum / double(poses.size());
  };
  const auto chosen = select_poses(rig.schema(), pool, 200, 0, unsure_of_0, 1);
  REQUIRE(chosen.size() == 200);
  CHECK(std::is_sorted(chosen.begin(), chosen.end()));
  CHECK(std::set<std::uint32_t>(chosen.begin(), chosen.end()).size() == 200);
  CHECK(mean_of(chosen) > 0.85);  // 0.4 in the pool
  // Of poses about as far from rest none with a larger score is left.
  const auto travel = [&](std::uint32_t pose) {
    double sum = 0;
    for (std::size_t c = 0; c < width; ++c) sum += std::abs(pool[pose * width + c]);
    return sum;
  };
  std::vector<double> travels;
  for (std::uint32_t pose = 0; pose < 2500; ++pose) travels.push_back(travel(pose));
  std::sort(travels.begin(), travels.end());
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    std::vector<float> taken, left;
    for (std::uint32_t pose = 0; pose < 2500; ++pose) {
      if (travel(pose) < travels[tenth * 250] || travel(pose) > travels[tenth * 250 + 249]) continue;
      if (std::binary_search(chosen.begin(), chosen.end(), pose)) {
        taken.push_back(scores[pose]);
      } else {
        left.push_back(scores[pose]);
      }
    }
    CHECK(taken.size() >= 15);
    CHECK(taken.size() <= 30);
    CHECK(*std::max_element(left.begin(), left.end()) <= *std::min_element(taken.begin(), taken.end()));
  }

  const auto mixed = select_poses(rig.schema(), pool, 200, 0.25, unsure_of_0, 1);
  const auto low = std::count_if(mixed.begin(), mixed.end(), [&](std::uint32_t p) { return scores[p] < 0.7f; });
  CHECK(low > 25);
  CHECK(low <= 60);
  CHECK(select_poses(rig.schema(), pool, 200, 0.25, unsure_of_0, 1) == mixed);
  CHECK(select_poses(rig.schema(), pool, 200, 0.25, unsure_of_0, 2) != mixed);
  CHECK(select_poses(rig.schema(), pool, 2500, 0.25, unsure_of_0, 2).size() == 2500);
}

TEST_CASE("near-duplicates do not crowd out other poses") {
  const MemorySource rig = live_face();
  std::vector<float> pool = random_pool(600);
  Random random(9);
  for (std::size_t pose = 100; pose < 500; ++pose)  // one expression, the rest of the face a little different
    for (std::size_t c = 0; c < width; ++c) pool[pose * width + c] = c < 3 ? 1 : random.uniform(-0.5f, 0.5f);
  const auto chosen = select_poses(rig.schema(), pool, 100, 0, unsure_of_0, 1);
  CHECK(std::count_if(chosen.begin(), chosen.end(), [](std::uint32_t p) { return p >= 100 && p < 500; }) == 2);
}

TEST_CASE("impossible selections are refused") {
  const MemorySource rig = live_face();
  const std::vector<float> pool = random_pool(20);
  failure(Status::invalid_argument, [&] { select_poses(rig.schema(), pool, 21, 0, unsure_of_0, 1); });
  failure(Status::invalid_argument, [&] { select_poses(rig.schema(), pool, 10, 1.5, unsure_of_0, 1); });
  const auto broken = [](std::span<const float>, std::size_t count) { return std::vector<float>(count, NAN); };
  failure(Status::not_finite, [&] { select_poses(rig.schema(), pool, 10, 0, broken, 1); });
  const auto short_of = [](std::span<const float>, std::size_t) { return std::vector<float>(1); };
  failure(Status::internal, [&] { select_poses(rig.schema(), pool, 10, 0, short_of, 1); });
}

TEST_CASE("rounds of selection extend a dataset within the rig budget, and continue where they were interrupted") {
  MemorySource rig = live_face();
  rig.add_clip("line", ClipKind::shot, Split::train, 12, 0.5f, 3);
  SamplingOptions options{.test_poses = false, .rig_budget = 1000};
  const ActiveSamplingOptions choice{.rounds = 3, .first_share = 0.4};
  std::vector<std::size_t> seen;
  const auto ensemble = [&](Source& recorded, std::uint32_t round) {
    CHECK(round == seen.size());
    seen.push_back(PoseSet(recorded, [](const Clip&) { return true; }).size());
    return EnsembleVariance(unsure_of_0);
  };
  const Folder whole, stopped;
  const SampleReport report = sample_actively(rig, options, choice, ensemble, whole.path(), {2}, silent_progress());
  CHECK(report.asked <= 1000);
  CHECK(report.asked > 950);
  const std::size_t drawn = 1000, answered = ControlResponses::poses_within(rig.schema(), 1000);
  CHECK(report.poses == drawn + 12);
  CHECK(report.evaluated == report.poses);
  REQUIRE(seen.size() == 3);
  CHECK(seen[0] == 12 + answered + std::size_t(double(drawn - answered) * 0.4));
  CHECK(seen[0] < seen[1]);
  CHECK(seen[1] < seen[2]);

  const auto recorded = open_source(whole.path());
  const auto mean_of_0 = [&](const std::string& part) {
    double sum = 0, frames = 0;
    for (const Clip& clip : recorded->clips())
      if (contains(clip.name, part))
        for (std::size_t f = 0; f < clip.frames; ++f, ++frames) sum += std::abs(clip.controls[f * width]);
    return sum / frames;
  };
  CHECK(recorded->clips().back().name == "chosen_2");
  CHECK(recorded->clips().back().split == Split::train);
  CHECK(mean_of_0("chosen") > 1.5 * mean_of_0("dense"));

  std::size_t attempts = 0;
  for (bool done = false; !done; ++attempts) {
    REQUIRE(attempts < 20);
    seen.clear();
    StopAt stop;
    stop.stop_at = attempts + 2;
    try {
      const SampleReport last = sample_actively(
          rig, options, choice, [](Source&, std::uint32_t) { return EnsembleVariance(unsure_of_0); }, stopped.path(),
          {1}, stop);
      CHECK(last.asked == report.asked);
      done = true;
    } catch (const Error& error) {
      REQUIRE(error.status() == Status::interrupted);
    }
  }
  CHECK(attempts > 2);
  const auto expected = files_of(whole.path()), files = files_of(stopped.path());
  CHECK(files.size() == expected.size());
  for (const auto& file : files)  // but for dataset.json, which says how fast the rig was
    if (file.first != "dataset.json")
      CHECK_MESSAGE((expected.count(file.first) && expected.at(file.first) == file.second), file.first);
  CHECK(contains(failure(Status::invalid_argument,
                         [&] {
                           sample_actively(rig, options, {.rounds = 2, .first_share = 0.4}, ensemble, whole.path(), {},
                                           silent_progress());
                         }),
                 "options"));
  failure(Status::invalid_argument,
          [&] { sample_actively(rig, options, {.rounds = 0}, ensemble, whole.path(), {}, silent_progress()); });
}

TEST_CASE("failing poses that an ensemble selects are left out, and the sampling goes on where it was interrupted") {
  const auto rig = open_hostile_rig("throws on a pose");
  const SamplingOptions options{.test_poses = false, .rig_budget = 400, .skip_failing = true};
  const auto ensemble = [&](Source&, std::uint32_t) {
    return [](std::span<const float> controls, std::size_t count) {
      std::vector<float> scores;
      for (std::size_t i = 0; i < count; ++i) scores.push_back(controls[6 * i + 2] * controls[6 * i + 3]);
      return scores;
    };
  };
  const Folder whole, stopped;
  const SampleReport report = sample_actively(*rig, options, {}, ensemble, whole.path(), {}, silent_progress());
  CHECK(report.left_out > 4);
  std::size_t attempts = 0;
  for (bool done = false; !done; ++attempts) {
    REQUIRE(attempts < 20);
    StopAt stop;
    stop.stop_at = attempts + 2;
    try {
      const SampleReport last = sample_actively(*rig, options, {}, ensemble, stopped.path(), {}, stop);
      CHECK(last.left_out == report.left_out);
      done = true;
    } catch (const Error& error) {
      REQUIRE_MESSAGE(error.status() == Status::interrupted, error.what());
    }
  }
  CHECK(attempts > 2);
  auto expected = files_of(whole.path()), files = files_of(stopped.path());
  expected.erase("dataset.json");
  files.erase("dataset.json");
  CHECK(files == expected);
}

TEST_CASE("a dataset is extended by clips and keeps its shards") {
  MemorySource rig = live_face();
  const Folder folder;
  const PosePlan plan = {{"first", ClipKind::dense, Split::train, 30, 20, random_pool(20)}};
  sample_to_dataset(rig, plan, folder.path(), {}, silent_progress());
  const auto before = files_of(folder.path());
  const Clip more = {"more", ClipKind::dense, Split::train, 30, 35, random_pool(35)};
  const SampleReport report = extend_dataset(rig, {more}, folder.path(), {}, silent_progress());
  CHECK(report.poses == 55);
  CHECK(report.evaluated == 35);
  CHECK(report.rig_calls == 36);
  const auto after = files_of(folder.path());
  for (const auto& file : before)
    if (file.first != "dataset.json") CHECK_MESSAGE(after.at(file.first) == file.second, file.first);
  const auto recorded = open_source(folder.path());
  REQUIRE(recorded->clips().size() == 2);
  CHECK(recorded->clips()[1].controls == more.controls);
  CHECK(extend_dataset(rig, {more}, folder.path(), {}, silent_progress()).evaluated == 0);
  CHECK(files_of(folder.path()) == after);
  Clip other = more;
  other.controls[0] = 0.123f;
  CHECK(contains(
      failure(Status::invalid_argument, [&] { extend_dataset(rig, {other}, folder.path(), {}, silent_progress()); }),
      "\"more\" is there with other controls"));
}

TEST_CASE("a rig budget covers single controls and new poses but no clips, or is refused") {
  const auto toy = open_toy();  // 6 controls, 24 frames of clips, of which 12 are a test
  CHECK(poses_to_draw(*toy, {.poses = 5000}) == 5000);
  CHECK(poses_to_draw(*toy, {.poses = 5000, .rig_budget = 1000}) == 1000);
  CHECK(poses_to_draw(*toy, {.poses = 300, .rig_budget = 1000}) == 300);
  CHECK(contains(failure(Status::invalid_argument, [&] { poses_to_draw(*toy, {.rig_budget = 6}); }), "at least"));
  for (const std::uint64_t budget : {400u, 100u}) {  // five values of each control, or the ends of its range
    const Folder folder;
    const SampleReport report = sample(*toy, {.rig_budget = budget}, folder.path(), {}, silent_progress());
    CHECK(report.poses == budget + 24);
    CHECK(report.asked <= budget);
    CHECK(report.asked > 0.95 * double(budget));  // equal poses are asked once
    const auto sampled = open_source(folder.path());
    const auto& clip = *std::ranges::find(sampled->clips(), "excitations", &Clip::name);
    CHECK(clip.frames >= ControlResponses::poses_within(toy->schema(), budget));
    const std::size_t width = toy->schema().control_count();
    for (std::size_t c = 0; c < width; ++c) {
      std::size_t ends = 0;
      for (std::size_t f = 0; f < clip.frames; ++f) {
        const float value = clip.controls[f * width + c];
        ends += value != toy->schema().controls[c].rest &&
                (value == toy->schema().controls[c].minimum || value == toy->schema().controls[c].maximum);
      }
      CHECK(ends >= 1);
    }
  }
  const Folder tested;
  sample(*toy, {.poses = 40, .test_poses = false}, tested.path(), {}, silent_progress());
  const auto source = open_source(tested.path());
  for (const Clip& clip : source->clips()) CHECK(clip.split != Split::test);
}

}  // namespace test_active_sampling
