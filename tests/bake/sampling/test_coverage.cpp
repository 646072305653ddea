#include "bake/sampling/coverage.h"

#include <algorithm>

#include "bake_test_support.h"
#include "base/random.h"

namespace test_coverage {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 20;

RigSchema face() {
  RigSchema schema;
  schema.name = "face";
  for (std::size_t c = 0; c < width; ++c)
    schema.controls.push_back({format("c%zu", c), c == 3 ? -2.0f : 0.0f, 1, 0, c < 10 ? "mouth" : "brow"});
  return schema;
}

// Poses in which each control is moved with this probability, up to `most` of its range.
std::vector<float> poses(std::size_t count, float probability, float most, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> all;
  for (std::size_t i = 0; i < count * width; ++i) {
    const bool on = random.uniform() < probability;
    const float value = most * random.uniform();
    all.push_back(on ? value : 0);
  }
  return all;
}

Coverage cover(const std::vector<float>& training, const std::vector<float>& target, int threads = 1) {
  const RigSchema schema = face();
  return measure_coverage(schema, control_groups(schema), training, target, {threads});
}

}  // namespace

TEST_CASE("alike sets cover each other") {
  const Coverage coverage = cover(poses(3000, 0.3f, 1, 1), poses(1500, 0.3f, 1, 2));
  CHECK(coverage.poses == TrainingTarget<std::size_t>{3000, 1500});
  REQUIRE(coverage.groups.size() == 2);
  for (const GroupCoverage& group : coverage.groups) {
    CHECK(group.uncovered < 0.08);
    CHECK(group.target_median == doctest::Approx(group.median).epsilon(0.1));
    CHECK(group.percentile_95 > group.median);
  }
  for (const ControlCoverage& control : coverage.controls) {
    CHECK(control.beyond < 0.01);
    CHECK(control.strong[0] == doctest::Approx(0.12).epsilon(0.3));
  }
  std::size_t all = 0;
  for (const std::size_t count : coverage.strong_counts[0]) all += count;
  CHECK(all == 3000);
}

TEST_CASE("what training poses lack is found: larger values, pairs, and values toward the minimum") {
  std::vector<float> training = poses(2000, 0.1f, 1, 3), target = poses(600, 0.1f, 1, 4);
  for (std::size_t i = 0; i < training.size(); i += width) training[i + 5] = std::min(training[i + 5], 0.5f);
  for (std::size_t i = 0; i < training.size(); i += width)
    if (training[i + 7] >= 0.6f) training[i + 2] = 0;  // never with 7
  for (std::size_t p = 0; p < 600; p += 3) {
    float* pose = target.data() + p * width;
    pose[5] = 0.9f;
    pose[2] = pose[7] = 0.8f;
    pose[3] = -1.8f;
    for (std::size_t c = 8; c < 10; ++c) pose[c] = 1;
  }
  const Coverage coverage = cover(training, target);
  CHECK(coverage.controls[5].highest[0] == 0.5f);
  CHECK(coverage.controls[5].beyond > 0.33);
  CHECK(coverage.controls[3].lowest[0] == 0);
  CHECK(coverage.controls[3].lowest[1] == doctest::Approx(0.9));
  CHECK(coverage.controls[3].beyond > 0.33);
  CHECK(coverage.controls[12].beyond < 0.01);
  CHECK(coverage.strong_counts[1].size() > 6);
  CHECK(coverage.groups[0].name == "mouth");
  CHECK(coverage.groups[0].uncovered > 0.3);
  CHECK(coverage.groups[1].uncovered < 0.1);
  const auto never = std::find_if(coverage.pairs.begin(), coverage.pairs.end(), [](const PairCoverage& pair) {
    return pair.controls == std::array<std::uint32_t, 2>{2, 7};
  });
  REQUIRE(never != coverage.pairs.end());
  CHECK(never->share[0] == 0);
  CHECK(never->share[1] > 0.33);
  CHECK(coverage.pairs.front().share[0] == 0);

  const std::string text = coverage_text(coverage, face());
  CHECK(contains(text, "2000 training poses, 600 target poses"));
  CHECK(contains(text, "c5  training -0.00 to 0.50"));
  CHECK(contains(text, "c3 down"));
}

TEST_CASE("coverage does not depend on threads, and knows rest without training") {
  const std::vector<float> training = poses(500, 0.4f, 1, 5), target = poses(200, 0.6f, 1, 6);
  const Coverage one = cover(training, target, 1), two = cover(training, target, 2);
  for (std::size_t r = 0; r < 2; ++r) CHECK(one.groups[r].uncovered == two.groups[r].uncovered);
  for (std::size_t p = 0; p < one.pairs.size(); ++p) CHECK(one.pairs[p].controls == two.pairs[p].controls);
  const std::vector<float> still(10 * width);
  for (const GroupCoverage& group : cover(training, still).groups) CHECK(group.uncovered == 0);
  for (const GroupCoverage& group : cover(still, target).groups) CHECK(group.uncovered == 1);
}

TEST_CASE("sets that are no poses are refused") {
  CHECK(contains(failure(Status::invalid_argument, [] { cover({}, poses(1, 1, 1, 1)); }), "no training poses"));
  CHECK(contains(failure(Status::invalid_argument, [] { cover(poses(1, 1, 1, 1), std::vector<float>(width + 1)); }),
                 "no target poses"));
}

}  // namespace test_coverage
