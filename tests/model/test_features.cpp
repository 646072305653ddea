// Values of features and activations.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "model/activation.h"
#include "model/feature_values.h"

namespace fb::test_features {
namespace {

float hat(float u, float threshold, float fall) {
  const Feature features[] = {{Feature::Kind::hat, 0, 1, threshold, fall}};
  const float rest = 0;
  float value = 0;
  feature_values(features, &u, &rest, &value);
  return value;
}

}  // namespace

TEST_CASE("a hat rises from its threshold over one unit and falls with the given slope") {
  CHECK(hat(0, 0.25f, 2) == 0);
  CHECK(hat(0.25f, 0.25f, 2) == 0);
  CHECK(hat(0.75f, 0.25f, 2) == 0.5f);
  CHECK(hat(1.25f, 0.25f, 2) == 1);
  CHECK(hat(1.5f, 0.25f, 2) == 0.5f);
  CHECK(hat(1.75f, 0.25f, 2) == 0);
  CHECK(hat(9, 0.25f, 2) == 0);
  CHECK(hat(9, 0.25f, 0) == 1);  // the last knot of a range
  CHECK(hat(-1, 0, 0) == 0);
}

TEST_CASE("features are 0 at rest, and products and minima combine earlier ones") {
  using Kind = Feature::Kind;
  const Feature features[] = {{Kind::identity, 1, 2},
                              {Kind::ramp, 0, -1, 0.5f},
                              {Kind::product, 0, 1, 0, 0, 0, 1},
                              {Kind::minimum, 0, 1, 0, 0, 0, 2}};
  const float rest[] = {0, 0.25f}, controls[] = {-2, 1.25f};
  float values[4];
  feature_values(features, controls, rest, values);
  CHECK(values[0] == 2);
  CHECK(values[1] == 1.5f);
  CHECK(values[2] == 3);
  CHECK(values[3] == 2);
  feature_values(features, rest, rest, values);
  for (const float value : values) CHECK(value == 0);
}

TEST_CASE("a feature of controls at rest is +0, whatever the other controls are") {
  using Kind = Feature::Kind;
  const Feature features[] = {{Kind::identity, 0, -1},
                              {Kind::identity, 1, 3e38f},
                              {Kind::product, 0, 1, 0, 0, 0, 1},
                              {Kind::product, 0, 1, 0, 0, 1, 0}};
  const float rest[] = {0.5f, 0}, controls[] = {0.5f, 9};
  float values[4];
  feature_values(features, controls, rest, values);
  CHECK(values[1] == INFINITY);
  for (const int f : {0, 2, 3}) CHECK((values[f] == 0 && !std::signbit(values[f])));
}

TEST_CASE("activations approximate the functions they are named for") {
  double worst_tanh = 0, worst_silu = 0;
  for (int i = -200000; i <= 200000; ++i) {
    const float x = float(i) * 1e-4f;
    worst_tanh = std::max(worst_tanh, std::fabs(rational_tanh(x) - std::tanh(double(x))));
    worst_silu = std::max(worst_silu, std::fabs(rational_silu(x) - x / (1 + std::exp(-double(x)))));
  }
  CHECK(worst_tanh < 1e-6);
  CHECK(worst_silu < 5e-6);
  CHECK(rational_tanh(0) == 0);
  CHECK(rational_tanh(-1.5f) == -rational_tanh(1.5f));
  CHECK(rational_tanh(1e30f) == rational_tanh(8));
}

}  // namespace fb::test_features
