#include "bake/analysis/corrective_fit.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace test_corrective_fit {

using namespace fb;
using namespace fb::bake;

namespace {

using Kind = Feature::Kind;

const std::vector<float> rest = {0, 0};

// Residuals of one vertex that moves by `along` of each point along x and `across` along y.
template <class Along, class Across>
std::vector<std::vector<float>> residuals_of(const std::vector<float>& poses, Along along, Across across) {
  std::vector<std::vector<float>> residuals;
  for (std::size_t i = 0; i < poses.size(); i += 2)
    residuals.push_back({float(along(poses[i], poses[i + 1])), float(across(poses[i], poses[i + 1])), 0});
  return residuals;
}

const std::vector<float> grid = {1, 1, 0.5f, 1, 1, 0.5f, 0.5f, 0.5f};

}  // namespace

TEST_CASE("minima are only of what never goes below 0") {
  std::vector<Feature> features = {{Kind::identity, 0}, {Kind::ramp, 0}, {Kind::ramp, 1}};
  const std::vector<std::uint32_t> first = {0, 1}, second = {2};
  const std::vector<std::uint32_t> composed = compose(features, first, second);
  REQUIRE(composed.size() == 3);
  CHECK(features[composed[0]].kind == Kind::product);
  CHECK(features[composed[1]].kind == Kind::product);
  CHECK(features[composed[2]].kind == Kind::minimum);
  CHECK(features[composed[2]].first == 1);
}

TEST_CASE("the features that explain the residual are selected, and no more") {
  std::vector<Feature> features = {{Kind::ramp, 0}, {Kind::ramp, 1}};
  const std::vector<std::uint32_t> a = {0}, b = {1};
  const std::vector<std::uint32_t> candidates = compose(features, a, b);
  const auto product = [](float x, float y) { return 0.5f * x * y; };
  const auto minimum = [](float x, float y) { return 0.25f * std::min(x, y); };
  const auto none = [](float, float) { return 0.0f; };
  const CorrectiveLimits limits{1e-3, 1e-5};
  CHECK(fit_corrective(features, candidates, grid, rest, residuals_of(grid, none, none), limits).shapes.empty());
  const SparseBlendshapes one =
      fit_corrective(features, candidates, grid, rest, residuals_of(grid, none, minimum), limits);
  REQUIRE(one.shapes.size() == 1);
  CHECK(one.features[one.shapes[0].feature].kind == Kind::minimum);
  CHECK(one.shapes[0].offsets[1] == doctest::Approx(0.25));
  const SparseBlendshapes both =
      fit_corrective(features, candidates, grid, rest, residuals_of(grid, product, minimum), limits);
  REQUIRE(both.shapes.size() == 2);
  std::vector<float> moved(3);
  const std::vector<float> pose = {0.3f, 0.8f};
  both.add(pose, rest, 1, 1, moved);
  CHECK(moved[0] == doctest::Approx(0.5 * 0.24));
  CHECK(moved[1] == doctest::Approx(0.25 * 0.3));
}

TEST_CASE("a feature that is small in all poses is not selected") {
  // The tent stands between the points and is nearly 0 at all of them; anything it took up there it would make large.
  const std::vector<Feature> features = {
      {Kind::hat, 0, 4, 2.0001f, 1}, {Kind::ramp, 1}, {Kind::product, 0, 1, 0, 0, 0, 1}};
  const std::vector<std::uint32_t> candidates = {2};
  const auto shown = [](float x, float y) { return x == 1 ? 0.0f : 0.1f * y; };
  const std::vector<float> points = {1, 1, 0.525f, 1, 1, 0.5f, 0.525f, 0.5f};
  CHECK(fit_corrective(features, candidates, points, rest, residuals_of(points, shown, shown), {1e-3, 1e-5})
            .shapes.empty());
}

}  // namespace test_corrective_fit
