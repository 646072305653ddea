#include "bake/analysis/sparse_blendshapes.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "bake/analysis/blocked_blendshapes.h"
#include "base/random.h"
#include "base/status.h"

namespace test_sparse_blendshapes {

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

TEST_CASE("part of the blendshapes moves some vertices as all of them do") {
  SparseBlendshapes base;
  base.features = {{Kind::identity, 0}, {Kind::identity, 1}};
  base.shapes = {{1, {0, 1, 3}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}, {0, {2}, {1, 1, 1}}};
  const std::vector<std::uint32_t> some = {1, 3, 4};
  const SparseBlendshapes part = part_of(base, some);
  REQUIRE(part.shapes.size() == 1);  // the other one moves none of them
  CHECK(part.shapes[0].feature == 1);
  CHECK(part.shapes[0].vertices == std::vector<std::uint32_t>{0, 1});
  CHECK(part.shapes[0].offsets == std::vector<float>{4, 5, 6, 7, 8, 9});
  const std::vector<float> controls = {2, 0.5f};
  std::vector<float> all(15), of_some(9);
  base.add(controls, rest, 1, 1, all);
  part.add(controls, rest, 1, 1, of_some);
  for (std::size_t i = 0; i < of_some.size(); ++i) CHECK(of_some[i] == all[3 * some[i / 3] + i % 3]);
}

TEST_CASE("blendshapes in blocks move poses as the shapes do") {
  constexpr std::size_t vertices = 50, controls = 9, count = 37;
  Random random(1);
  SparseBlendshapes base;
  for (std::uint32_t c = 0; c < controls; ++c) base.features.push_back({Kind::identity, c});
  base.features.push_back({Kind::product, 0, 1, 0, 0, 3, 4});
  for (std::uint32_t f = 0; f < base.features.size(); ++f) {
    SparseShape shape{f, {}, {}};
    for (std::uint32_t v = 0; v < vertices; ++v) {
      if (random.below(3) == 0) continue;
      shape.vertices.push_back(v);
      for (int axis = 0; axis < 3; ++axis) shape.offsets.push_back(random.normal());
    }
    base.shapes.push_back(shape);
  }
  const std::vector<float> still(controls, 0.0f);
  std::vector<float> poses(count * controls);
  for (std::size_t i = controls; i < poses.size(); ++i)  // the first pose is at rest
    if (random.below(2)) poses[i] = random.normal();
  std::vector<float> expected(count * 3 * vertices, 0.5f), out = expected;
  base.add(poses, still, count, -1, expected);
  const BlockedBlendshapes blocked(base, vertices);
  blocked.add(poses, still, count, -1, out);
  for (std::size_t i = 0; i < out.size(); ++i) REQUIRE(out[i] == doctest::Approx(expected[i]).epsilon(1e-5));
  CHECK(std::all_of(out.begin(), out.begin() + 3 * vertices, [](float value) { return value == 0.5f; }));
  // The same bits alone.
  for (std::size_t p = 0; p < count; p += 5) {
    std::vector<float> alone(3 * vertices, 0.5f);
    blocked.add(std::span(poses).subspan(p * controls, controls), still, 1, -1, alone);
    CHECK(std::equal(alone.begin(), alone.end(), out.begin() + static_cast<std::ptrdiff_t>(p * 3 * vertices)));
  }
  CHECK_THROWS_AS(blocked.add(poses, still, count - 1, 1, out), Error);
}

}  // namespace test_sparse_blendshapes
