#include "bake/compress/rate_distortion.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "archive/coding/writer/coding_writer.h"
#include "base/random.h"
#include "grid_quads.h"

namespace test_rate_distortion {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

constexpr std::uint32_t side = 24, columns = 12, block_rows = 3 * 96;

struct Rounded {
  PackedModel model;
  std::vector<std::vector<float>> exact;  // see rate_distortion_quantise

  double mean_square_error() const {  // in steps of `exact`
    double sum = 0;
    for (std::size_t g = 0; g < exact.size(); ++g)
      for (std::size_t i = 0; i < exact[g].size(); ++i) {
        const double off = model.row_blocks[g].values[i] - exact[g][i];
        sum += off * off;
      }
    return sum / (3.0 * side * side * columns);
  }
  std::size_t bytes() const { return write_basis(model).values.bytes.size(); }
};

// A square grid of quads, smooth columns with a little noise, rounded to the nearest multiple of `step`.
Rounded rounded(float step) {
  Rounded made;
  PackedModel& model = made.model;
  model.columns = columns;
  for (std::uint32_t v = 0; v < side * side; ++v)
    for (const std::uint32_t x : {v % side, v / side, 0u}) model.rest.points.push_back(static_cast<float>(x));
  add_grid_quads(model.rest, side);
  Random random(3);
  for (std::uint32_t row = 0; row < 3 * side * side; row += block_rows) {
    PackedRowBlock& group = model.row_blocks.emplace_back();
    group.first_row = row;
    group.row_count = block_rows;
    std::vector<float>& exact = made.exact.emplace_back();
    for (std::uint32_t c = 0; c < columns; ++c) {
      group.columns.push_back({c, false, step});
      for (std::uint32_t r = row; r < row + block_rows; ++r) {
        const float x = float(r / 3 % side) / side, y = float(r / 3) / (side * side);
        const float wave = 12 * std::sin(3 * x + float(c)) * std::sin(4 * y + float(r % 3));
        exact.push_back((wave + random.uniform(-0.7f, 0.7f)) / step);
        group.values.push_back(static_cast<std::int16_t>(std::nearbyint(exact.back())));
      }
    }
  }
  return made;
}

}  // namespace

TEST_CASE("rate-distortion optimised quantisation takes fewer bytes for the same error") {
  const Rounded nearest = rounded(1.2f);
  Rounded optimised = rounded(1);
  const std::size_t before = optimised.bytes();
  rate_distortion_quantise(optimised.model, optimised.exact, {});
  CHECK(optimised.bytes() < before);
  CHECK(optimised.mean_square_error() < 1.44 * nearest.mean_square_error());
  CHECK(double(optimised.bytes()) < 0.97 * double(nearest.bytes()));
  for (std::size_t g = 0; g < optimised.exact.size(); ++g)
    for (std::size_t i = 0; i < optimised.exact[g].size(); ++i)
      CHECK(std::fabs(optimised.model.row_blocks[g].values[i] - optimised.exact[g][i]) < 1);
}

TEST_CASE("a large lambda rounds to nearest") {
  Rounded precise = rounded(1);
  const PackedModel before = precise.model;
  rate_distortion_quantise(precise.model, precise.exact, {.lambda = 1e6});
  for (std::size_t g = 0; g < before.row_blocks.size(); ++g)
    CHECK(precise.model.row_blocks[g].values == before.row_blocks[g].values);
}

}  // namespace test_rate_distortion
