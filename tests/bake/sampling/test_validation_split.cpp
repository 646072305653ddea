#include "bake/sampling/validation_split.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "bake_test_support.h"
#include "memory_source.h"

namespace test_validation_split {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t controls = 8;

MemorySource still_face() {
  return MemorySource(controls, 3, [](const float*, std::span<float>) {});
}

PoseSet all_of(Source& source) {
  return PoseSet(source, [](const Clip&) { return true; });
}

// Makes a clip of smooth sequences of `length` frames out of random keys.
void smooth(Clip& clip, std::size_t length) {
  const std::vector<float> keys = clip.controls;
  for (std::size_t f = 0; f < clip.frames; ++f)
    for (std::size_t c = 0; c < controls; ++c) {
      const std::size_t sequence = f / length;
      const float t = static_cast<float>(f % length) / static_cast<float>(length);
      const float from = keys[(2 * sequence % clip.frames) * controls + c];
      const float to = keys[((2 * sequence + 1) % clip.frames) * controls + c];
      clip.controls[f * controls + c] = from + (to - from) * t;
    }
}

std::size_t validation_share_of_poses(const PoseSet& poses, const ValidationSplit& split, const std::string& name) {
  std::size_t count = 0;
  for (const PoseSet::Range& range : poses.ranges())
    if (poses.source().clips()[range.clip].name == name)
      for (const std::uint32_t pose : split.validation)
        count += pose >= range.first_pose && pose < range.first_pose + range.count;
  return count;
}

}  // namespace

TEST_CASE("validation takes about its share of every kind, whole validation clips and no excitation") {
  MemorySource source = still_face();
  source.add_clip("single", ClipKind::excitation, Split::train, 400, 0.1f, 1);
  source.add_clip("dense", ClipKind::dense, Split::train, 2000, 0.5f, 2);
  source.add_clip("walk", ClipKind::calisthenics, Split::train, 3000, 1, 3);
  smooth(source.edit_clip(2), 60);
  source.add_clip("line", ClipKind::shot, Split::validation, 70, 1, 4);
  const PoseSet poses = all_of(source);
  const ValidationSplit split = validation_split(poses, 0.05, 7);
  CHECK(validation_share_of_poses(poses, split, "single") == 0);
  CHECK(validation_share_of_poses(poses, split, "dense") == 100);
  CHECK(validation_share_of_poses(poses, split, "walk") >= 150);
  CHECK(validation_share_of_poses(poses, split, "walk") < 150 + 60);
  CHECK(validation_share_of_poses(poses, split, "line") == 70);
  CHECK(std::is_sorted(split.training.begin(), split.training.end()));
  CHECK(std::is_sorted(split.validation.begin(), split.validation.end()));
  std::set<std::uint32_t> both(split.training.begin(), split.training.end());
  both.insert(split.validation.begin(), split.validation.end());
  CHECK(both.size() == poses.size());
  CHECK(split.training.size() + split.validation.size() == poses.size());

  CHECK(validation_split(poses, 0.05, 7).validation == split.validation);
  CHECK(validation_split(poses, 0.05, 8).validation != split.validation);
  CHECK(validation_split(poses, 0, 7).validation.size() == 70);
}

TEST_CASE("sequences are kept whole, long ones are cut into long pieces") {
  MemorySource source = still_face();
  source.add_clip("walk", ClipKind::calisthenics, Split::train, 6000, 1, 5);
  smooth(source.edit_clip(0), 60);
  const PoseSet walks = all_of(source);
  std::set<std::uint32_t> kept;
  for (const std::uint32_t pose : validation_split(walks, 0.05, 1).validation) kept.insert(pose);
  for (std::uint32_t sequence = 0; sequence < 100; ++sequence) {
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < 60; ++f) count += kept.count(sequence * 60 + f);
    CHECK((count == 0 || count == 60));
  }

  MemorySource shots = still_face();
  shots.add_clip("take", ClipKind::shot, Split::train, 4000, 1, 6);
  smooth(shots.edit_clip(0), 4000);
  const std::vector<std::uint32_t> poses = validation_split(all_of(shots), 0.05, 1).validation;
  REQUIRE(poses.size() >= 180);
  std::size_t runs = 1;
  for (std::size_t i = 1; i < poses.size(); ++i) runs += poses[i] != poses[i - 1] + 1;
  CHECK(runs <= 3);
}

TEST_CASE("of few short shots, a whole one is held back") {
  MemorySource shots = still_face();
  for (std::uint64_t take = 0; take < 5; ++take)
    shots.add_clip("take" + std::to_string(take), ClipKind::shot, Split::train, 60, 1, 10 + take);
  const PoseSet takes = all_of(shots);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<std::uint32_t> held = validation_split(takes, 0.05, seed).validation;
    REQUIRE(held.size() == 60);
    CHECK(held.front() % 60 == 0);
    CHECK(held.back() == held.front() + 59);
  }
}

TEST_CASE("a set keeps enough to train on, and test clips are refused") {
  MemorySource source = still_face();
  source.add_clip("short", ClipKind::shot, Split::train, 3, 1, 7);
  const PoseSet few = all_of(source);
  CHECK(validation_split(few, 0.05, 1).validation.empty());
  CHECK(2 * validation_split(few, 0.9, 1).validation.size() <= 3);
  failure(Status::invalid_argument, [&] { validation_split(few, 1, 1); });
  failure(Status::invalid_argument, [&] { validation_split(few, std::nan(""), 1); });
  source.add_clip("premiere", ClipKind::shot, Split::test, 30, 1, 8);
  CHECK(contains(failure(Status::invalid_argument, [&] { validation_split(all_of(source), 0.05, 1); }),
                 "\"premiere\" is a test clip"));
}

TEST_CASE("poses picked from a set are those poses") {
  MemorySource source = still_face();
  source.add_clip("a", ClipKind::dense, Split::train, 10, 1, 9);
  source.add_clip("b", ClipKind::dense, Split::train, 10, 1, 10);
  const PoseSet poses = all_of(source);
  const std::vector<std::uint32_t> wanted = {3, 4, 5, 12, 9, 10};
  const PoseSet some = poses.picked(wanted);
  REQUIRE(some.size() == wanted.size());
  CHECK(some.ranges().size() == 4);
  const std::vector<float> all = poses.controls(), picked = some.controls();
  for (std::size_t i = 0; i < wanted.size(); ++i)
    CHECK(std::equal(picked.begin() + long(i * controls), picked.begin() + long((i + 1) * controls),
                     all.begin() + long(wanted[i] * controls)));
  const std::vector<std::uint32_t> beyond = {20};
  failure(Status::invalid_argument, [&] { poses.picked(beyond); });
}

}  // namespace test_validation_split
