#include "bake/measure/errors.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace test_errors {

using namespace fb;
using namespace fb::bake;

namespace {

// A frame of vertices at these distances from the truth, along changing axes.
void add(ErrorSums& sums, const std::vector<float>& distances) {
  std::vector<float> truth, predicted;
  for (std::size_t v = 0; v < distances.size(); ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      truth.push_back(float(v));
      predicted.push_back(float(v) + (axis == v % 3 ? distances[v] : 0.0f));
    }
  sums.add_frame(predicted, truth);
}

}  // namespace

TEST_CASE("figures are those of their definitions, over the diagonal") {
  ErrorSums sums;
  add(sums, {0, 1, 2, 1});
  add(sums, {0, 0, 0, 4});
  const Errors e = sums.figures(10);
  CHECK(e.frames == 2);
  CHECK(e.mse == doctest::Approx((1 + 4 + 1 + 16) / 8.0 / 100));
  CHECK(e.rms == doctest::Approx(std::sqrt(e.mse)));
  // The frames' mean squares, 1.5 and 4, lie 1.25 from their mean, 2.75; a mean of two is off by 1 / sqrt(2) of that.
  CHECK(e.rms_deviation == doctest::Approx(e.rms * 1.25 / std::sqrt(2.0) / (2 * 2.75)));
  CHECK(e.mean == doctest::Approx(8 / 8.0 / 10));
  CHECK(e.max == doctest::Approx(0.4));
  CHECK(e.mfm == doctest::Approx((0.2 + 0.4) / 2));
  CHECK(e.p99fm == doctest::Approx(0.4));
  CHECK(e.worst_frame == 1);
  CHECK(e.p99 == doctest::Approx(0.4));
}

TEST_CASE("the 99th percentile leaves one vertex in a hundred beyond it") {
  ErrorSums sums;
  std::vector<float> distances;
  for (int i = 1; i <= 1000; ++i) distances.push_back(std::pow(1.02f, float(i)));
  add(sums, distances);
  CHECK(sums.figures(1).p99 == doctest::Approx(std::pow(1.02, 990)).epsilon(0.012));
  CHECK(sums.figures(1).max == doctest::Approx(distances.back()));
}

TEST_CASE("one frame in a hundred has a vertex beyond the 99th percentile of the frame maxima") {
  ErrorSums sums;
  for (int f = 1; f <= 1000; ++f) add(sums, {std::pow(1.01f, float(f)), 0, 0.5f});
  CHECK(sums.figures(1).p99fm == doctest::Approx(std::pow(1.01, 990)));
  CHECK(sums.figures(1).max == doctest::Approx(std::pow(1.01, 1000)));
}

TEST_CASE("sums joined in order are the sums of all frames") {
  ErrorSums all, first, second;
  for (int f = 0; f < 6; ++f) {
    const std::vector<float> distances = {0.25f * float(f), 0.5f, f == 4 ? 9.0f : 0.125f};
    add(all, distances);
    add(f < 2 ? first : second, distances);
  }
  ErrorSums joined;
  joined.append(first);
  joined.append(ErrorSums());
  joined.append(second);
  const Errors a = all.figures(3), b = joined.figures(3);
  CHECK(a.frames == b.frames);
  CHECK(a.mse == doctest::Approx(b.mse));
  CHECK(a.rms_deviation == doctest::Approx(b.rms_deviation));
  CHECK(a.mfm == doctest::Approx(b.mfm));
  CHECK(a.p99 == b.p99);
  CHECK(a.p99fm == b.p99fm);
  CHECK(a.max == b.max);
  CHECK(b.worst_frame == 4);
}

TEST_CASE("no frames have no errors") {
  CHECK(ErrorSums().figures(1).frames == 0);
}

}  // namespace test_errors
