#include "bake/sampling/linear_rig.h"

#include <cmath>

#include "bake/pipeline/sample_poses.h"
#include "bake_test_support.h"
#include "memory_source.h"

namespace test_linear_rig {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 12, side = 6;

// Each control moves a vertex along z, in proportion to `of` it and all others.
using Amount = std::function<float(const float* controls, std::size_t control)>;
MemorySource rig_of(const Amount& of) {
  return MemorySource(
      width, side,
      [of](const float* controls, std::span<float> points) {
        for (std::size_t c = 0; c < width; ++c) points[3 * c + 2] += of(controls, c);
      },
      true);
}

bool linear(MemorySource rig) {
  RigEvaluator evaluator(rig);
  return is_linear(evaluator, 1, silent_progress());
}

}  // namespace

TEST_CASE("rigs that are sums of blendshapes are linear, also where the ends of a range differ") {
  CHECK(linear(rig_of([](const float* c, std::size_t i) { return 0.5f * c[i]; })));
  CHECK(linear(rig_of([](const float* c, std::size_t i) { return c[i] > 0 ? 2 * c[i] : 0.1f * c[i]; })));
  CHECK(linear(rig_of([](const float*, std::size_t) { return 0.0f; })));
  MemorySource one_sided = rig_of([](const float* c, std::size_t i) { return c[i] - 0.25f; });
  for (Control& control : one_sided.edit_schema().controls) control.minimum = control.rest = 0.25f;
  CHECK(linear(std::move(one_sided)));
}

TEST_CASE("a curve, and two controls of many that act together, are found") {
  CHECK_FALSE(linear(rig_of([](const float* c, std::size_t i) { return i == 7 ? c[i] * c[i] : c[i]; })));
  CHECK_FALSE(linear(rig_of([](const float* c, std::size_t i) { return i == 7 ? c[7] * (1 + 0.1f * c[2]) : c[i]; })));
  CHECK_FALSE(linear(rig_of([](const float* c, std::size_t i) { return i == 7 ? std::max(c[7], c[2]) : c[i]; })));
}

TEST_CASE("a rig that gives no number in some poses is not linear") {
  CHECK_FALSE(linear(rig_of([](const float* c, std::size_t i) { return c[3] > 0.5f ? NAN : c[i]; })));
}

TEST_CASE("of a linear rig fewer poses are sampled, unless a number of them is asked for") {
  MemorySource rig = rig_of([](const float* c, std::size_t i) { return c[i]; });
  MemorySource curved = rig_of([](const float* c, std::size_t i) { return c[i] * c[i]; });
  RigEvaluator evaluator(rig), other(curved);
  const auto wanted = [&](RigEvaluator& of, std::uint64_t poses, std::uint64_t budget, bool recipe_evaluates) {
    BakeOptions options;
    options.poses = poses;
    options.rig_budget = budget;
    return wanted_poses(of, options, {recipe_evaluates}, silent_progress()).count;
  };
  CHECK(wanted(evaluator, 0, 0, true) == 2000);
  CHECK(wanted(evaluator, 0, 0, false) == 20000);
  CHECK(wanted(evaluator, 300, 0, true) == 300);
  CHECK(wanted(evaluator, 0, 500, true) == 500);
  CHECK(wanted(evaluator, 0, 10000, true) == 2000);
  CHECK(wanted(other, 0, 10000, true) == 10000);
  CHECK(wanted(other, 0, 0, true) == 20000);
  BakeOptions like;
  like.examples.assign(width, 0.5f);
  CHECK(wanted_poses(evaluator, like, {true}, silent_progress()).count == 20000);
}

}  // namespace test_linear_rig
