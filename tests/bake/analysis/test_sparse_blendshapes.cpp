#include "bake/analysis/sparse_blendshapes.h"

#include <doctest/doctest.h>

#include "base/status.h"

using namespace fb;
using namespace fb::bake;

namespace {

using Kind = Feature::Kind;

// Two controls at rest at 1 and 0.
const std::vector<float> rest = {1, 0};

std::vector<float> values_of(const std::vector<Feature>& features, const std::vector<float>& controls) {
  std::vector<float> values(features.size(), 99.0f);
  evaluate_features(features, controls, rest, values);
  return values;
}

}  // namespace

TEST_CASE("features have the values that the format defines") {
  const std::vector<Feature> features = {
      {Kind::identity, 0, 2},           {Kind::ramp, 0, 1, 0.25f}, {Kind::ramp, 1, -1},
      {Kind::hat, 0, 4, 1, 0.5f},       {Kind::hat, 0, 2, 1, 0},   {Kind::product, 0, 1, 0, 0, 1, 4},
      {Kind::minimum, 0, 1, 0, 0, 2, 4}};
  CHECK(values_of(features, rest) == std::vector<float>(7, 0.0f));
  CHECK(values_of(features, {1.5f, -0.75f}) == std::vector<float>{1, 0.25f, 0.75f, 1, 0, 0, 0});
  // u = .75: the first hat is a quarter unit of its own past its knot's double, the second half way up.
  CHECK(values_of(features, {1.75f, -0.25f}) == std::vector<float>{1.5f, 0.5f, 0.25f, 0.5f, 0.5f, 0.25f, 0.25f});
  // A hat with fall 0 stays 1 behind its knot; the other is back at 0.
  CHECK(values_of(features, {3, 1}) == std::vector<float>{4, 1.75f, 0, 0, 1, 1.75f, 0});
}

TEST_CASE("shapes are added to every pose, and subtracted again") {
  SparseBlendshapes base;
  base.features = {{Kind::identity, 0}, {Kind::identity, 1}, {Kind::product, 0, 1, 0, 0, 0, 1}};
  base.shapes = {{1, {0, 1, 3}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}, {2, {2}, {1, 1, 1}}};
  constexpr std::size_t count = 21;  // more poses than are taken together
  std::vector<float> controls, out(count * 12, 0.5f);
  for (std::size_t i = 0; i < count; ++i) controls.insert(controls.end(), {1.0f + float(i % 3), float(i)});
  base.add(controls, rest, count, 2, out);
  for (std::size_t i = 0; i < count; ++i) {
    const float b = 2 * float(i), ab = b * float(i % 3);
    const std::vector<float> expected = {b, 2 * b, 3 * b, 4 * b, 5 * b, 6 * b, ab, ab, ab, 7 * b, 8 * b, 9 * b};
    for (std::size_t k = 0; k < 12; ++k) REQUIRE(out[i * 12 + k] == 0.5f + expected[k]);
  }
  base.add(controls, rest, count, -2, out);
  CHECK(out == std::vector<float>(count * 12, 0.5f));
  CHECK_THROWS_AS(base.add(controls, rest, count - 1, 1, out), Error);
}
