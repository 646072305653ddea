#include "bake/pipeline/learning_curve.h"

#include <algorithm>
#include <cmath>

#include "bake_test_support.h"

namespace test_learning_curve {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

Errors errors(double mse) {
  Errors errors;
  errors.mse = mse;
  return errors;
}

}  // namespace

TEST_CASE("a learning curve is measured on nested sets and recovers a power law") {
  std::vector<std::vector<std::uint32_t>> sets;
  const auto power = [&](std::span<const std::uint32_t> poses) {
    sets.emplace_back(poses.begin(), poses.end());
    return errors(1e-3 * std::pow(double(poses.size()), -0.7));
  };
  const LearningCurve curve = learning_curve(4000, 3, power, silent_progress());
  REQUIRE(curve.points.size() == 4);
  const std::size_t sizes[] = {500, 1000, 2000, 4000};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(curve.points[i].poses == sizes[i]);
    REQUIRE(sets[i].size() == sizes[i]);
    CHECK(std::is_sorted(sets[i].begin(), sets[i].end()));
    CHECK(std::adjacent_find(sets[i].begin(), sets[i].end()) == sets[i].end());
    if (i > 0) CHECK(std::includes(sets[i].begin(), sets[i].end(), sets[i - 1].begin(), sets[i - 1].end()));
  }
  CHECK(sets[0].back() > 3900);  // from all over the set
  CHECK(curve.exponent == doctest::Approx(0.7));
  CHECK(curve.mse_at(8000) == doctest::Approx(1e-3 * std::pow(8000, -0.7)));
  CHECK(curve.deviation < 1e-9);
  CHECK(contains(outlook_text(curve), "twice the poses would give an mse of about 1.9e-06"));

  const auto first = sets[0];
  sets.clear();
  learning_curve(4000, 3, power, silent_progress());
  CHECK(sets[0] == first);
  sets.clear();
  learning_curve(4000, 4, power, silent_progress());
  CHECK(sets[0] != first);
}

TEST_CASE("the curve's words fit what was measured") {
  const auto level = [](std::span<const std::uint32_t>) { return errors(2e-6); };
  CHECK(contains(outlook_text(learning_curve(160, 1, level, silent_progress())), "would not lower the error"));
  const auto exact = [](std::span<const std::uint32_t>) { return errors(0); };
  CHECK(contains(outlook_text(learning_curve(160, 1, exact, silent_progress())), "more poses cannot lower it"));
  // Off the line by 10 % up and down.
  double sign = 1;
  const auto noisy = [&](std::span<const std::uint32_t> poses) {
    sign = -sign;
    return errors((1 + 0.1 * sign) / double(poses.size()));
  };
  const LearningCurve curve = learning_curve(160, 1, noisy, silent_progress());
  CHECK(curve.deviation > 0.03);
  CHECK(curve.deviation < 0.15);
  CHECK(curve.exponent == doctest::Approx(1).epsilon(0.05));
}

TEST_CASE("what makes no learning curve is refused") {
  const auto none = [](std::span<const std::uint32_t>) { return errors(NAN); };
  failure(Status::invalid_argument, [&] { learning_curve(15, 1, none, silent_progress()); });
  CHECK(contains(failure(Status::not_finite, [&] { learning_curve(16, 1, none, silent_progress()); }), "on 2 poses"));
}

}  // namespace test_learning_curve
