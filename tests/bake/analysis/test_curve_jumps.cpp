#include "bake/analysis/curve_jumps.h"

#include <doctest/doctest.h>

#include <cmath>

#include "bake/analysis/rig_analysis.h"
#include "bake/recipe/bake_options.h"
#include "bake/sampling/pose_generators.h"
#include "base/random.h"
#include "memory_source.h"
#include "model/feature_values.h"

namespace test_curve_jumps {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 4;

// A live rig of one control that moves all vertices, more or less, by f(value).
MemorySource rig_of(float minimum, float rest, float maximum, double (*f)(float)) {
  const double at_rest = f(rest);
  MemorySource rig(
      1, side,
      [=](const float* c, std::span<float> points) {
        for (std::size_t i = 0; i < points.size(); ++i)
          points[i] += static_cast<float>((f(c[0]) - at_rest) * std::cos(0.2 * static_cast<double>(i)));
      },
      true);
  rig.edit_schema().controls[0] = {"control", minimum, maximum, rest, ""};
  return rig;
}

struct Wrong {
  double error = 0;  // over the diagonal
  float value = 0;
};

// The worst of the base at random values and at `also`.
Wrong worst(MemorySource& rig, const SparseBlendshapes& base, const std::vector<float>& also = {}) {
  const Control control = rig.schema().controls[0];
  std::vector<float> values = also, points(rig.rest().points.size());
  Random random(3);
  for (int i = 0; i < 3000; ++i) values.push_back(random.uniform(control.minimum, control.maximum));
  Wrong worst;
  for (const float value : values) {
    rig.evaluate({&value, 1}, 1, points);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] -= rig.rest().points[i];
    base.add({&value, 1}, {&control.rest, 1}, 1, -1, points);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const double error = std::hypot(double(points[i]), points[i + 1], points[i + 2]) / rig.rest().diagonal();
      if (error > worst.error) worst = {error, value};
    }
  }
  return worst;
}

RigAnalysis analyse(MemorySource& source) {
  RigEvaluator rig(source);
  return analyse_rig(rig, {}, silent_progress());
}

std::size_t steps_of(const RigAnalysis& analysis) {
  std::size_t steps = 0;
  for (const SparseShape& shape : analysis.base.shapes) steps += is_step(analysis.base.features[shape.feature]);
  return steps;
}

std::vector<float> beside(std::initializer_list<float> values) {
  std::vector<float> all;
  for (const float value : values)
    for (const float other : {std::nextafter(value, -INFINITY), value, std::nextafter(value, INFINITY)})
      all.push_back(other);
  return all;
}

}  // namespace

TEST_CASE("a step is 0 up to a value and 1 from the next on, for any range, rest and side") {
  for (const auto& [minimum, rest, maximum] : {std::array{-1.0f, 0.0f, 1.0f},
                                               {0.0f, 0.5f, 2.0f},
                                               {-300.0f, 7.0f, 900.0f},
                                               {-2e-7f, 0.0f, 3e-6f},
                                               {1000.0f, 1000.0f, 1001.0f}}) {
    const Control control{"control", minimum, maximum, rest, ""};
    for (const bool up : {false, true})
      for (const double position : {0.013, 0.25, 0.5, 0.77, 0.999}) {
        if (!has_side(control, up)) continue;
        // The next value whose offset from rest, which readers compute in floats, differs.
        const double inside = up ? position : -position;
        const float before = value_at(control, inside);
        double outside = inside;
        while (value_at(control, outside) - rest == before - rest) outside += up ? 1e-9 : -1e-9;
        const Feature feature = step(control, 0, inside, outside);
        const auto value = [&, rest = rest](float c) { return control_feature(feature, c, rest); };
        CHECK(value(rest) == 0);
        CHECK(value(before) == 0);
        CHECK(value(value_at(control, outside)) == 1);
        CHECK(value(up ? maximum : minimum) == 1);
        CHECK(is_step(feature));
      }
  }
}

TEST_CASE("controls that jump are found and modelled to the float before and after") {
  struct Case {
    float minimum, rest, maximum;
    double (*f)(float);
    std::size_t steps;
    std::vector<float> jumps;
  };
  const Case cases[] = {
      {0, 0, 1, [](float c) { return 0.3 * (c >= 0.5f); }, 1, {0.5f}},
      {-1, 0, 1, [](float c) { return 0.4 * (c > 0.137f) - 0.3 * (c < -0.61f); }, 2, {0.137f, -0.61f}},
      {0, 0.5f, 2, [](float c) { return 0.2 * c + 0.4 * (c > 1.2345f) - 0.2 * (c < 0.21f); }, 2, {1.2345f, 0.21f}},
      {0, 0, 1, [](float c) { return 0.4 * (c > 0); }, 1, {1e-6f}},
      {0, 0, 5, [](float c) { return 0.1 * std::floor(c); }, 5, {1, 2, 3, 4}},
      {0, 0, 1, [](float c) { return 0.1 * std::floor(8 * c); }, 8, {0.125f, 0.5f, 0.875f}},
      {-10, 0, 10, [](float c) { return 0.05 * std::round(c); }, 20, {0.5f, -7.5f}},
      {0, 0, 1, [](float c) { return 0.5 * c * c + (c > 0.3f ? 0.2 * c : 0); }, 1, {0.3f}},
  };
  for (const Case& one : cases) {
    CAPTURE(one.jumps[0]);
    MemorySource rig = rig_of(one.minimum, one.rest, one.maximum, one.f);
    const RigAnalysis analysis = analyse(rig);
    CHECK(steps_of(analysis) == one.steps);
    std::vector<float> values;
    for (const float jump : one.jumps)
      for (const float value : beside({jump}))
        if (value >= one.minimum && value <= one.maximum) values.push_back(value);
    const Wrong wrong = worst(rig, analysis.base);
    CAPTURE(wrong.value);
    CHECK(wrong.error < 2e-4);
    // One float off at most, where offsets from rest are rounded.
    if (one.rest == 0) CHECK(worst(rig, analysis.base, values).error < 2e-4);
  }
}

TEST_CASE("excitations are sampled on both sides of jumps, which a recording of them shows") {
  double (*const f)(float) = [](float c) { return 0.3 * c + 0.4 * (c > 0.1379f) - 0.3 * (c < -0.613f); };
  MemorySource rig = rig_of(-1, 0, 1, f);
  RigEvaluator evaluator(rig);
  const ControlResponses responses(evaluator, 0, silent_progress());
  const std::vector<float> values = make_excitations(rig.schema(), responses, 40);
  CHECK(values.size() == 40);
  for (const float side : {0.1379f, std::nextafter(0.1379f, 1.0f), -0.613f, std::nextafter(-0.613f, -1.0f)})
    CHECK(std::ranges::count(values, side) == 1);

  MemorySource recording = rig_of(-1, 0, 1, f);
  recording.add_clip("excitations", ClipKind::excitation, Split::train, values.size(), 1, 1);
  recording.edit_clip(0).controls = values;
  const PoseSet poses = training_poses(recording, Use::variant);
  const RigAnalysis analysis = analyse_poses(poses, {}, {}, silent_progress());
  CHECK(steps_of(analysis) == 2);
  CHECK(worst(rig, analysis.base).error < 1e-5);
}

TEST_CASE("a control that oscillates gets the knots it needs") {
  MemorySource rig = rig_of(0, 0, 1, [](float c) { return 0.3 * std::sin(40.0 * c); });
  const RigAnalysis analysis = analyse(rig);
  CHECK(worst(rig, analysis.base).error < 1e-3);
  CHECK(analysis.base.shapes.size() <= 256);
}

TEST_CASE("smooth and cornered curves are sampled no closer than before") {
  for (double (*f)(float) :
       {+[](float c) { return double(c); }, +[](float c) { return c * c - 0.3 * c; },
        +[](float c) { return std::max(0.0, c - 0.7); }, +[](float c) { return 0.05 * std::sin(3.0 * c); }}) {
    MemorySource rig = rig_of(-1, 0, 1, f);
    const RigAnalysis analysis = analyse(rig);
    CHECK(analysis.rig_calls < 150);
    CHECK(steps_of(analysis) == 0);
  }
}

}  // namespace test_curve_jumps
