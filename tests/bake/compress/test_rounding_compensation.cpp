#include "bake/compress/rounding_compensation.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "bake/compress/pack_model.h"
#include "bake/compress/vertex_spacing.h"
#include "bake/measure/float_face.h"
#include "base/random.h"
#include "base/status.h"
#include "grid_quads.h"
#include "test_models.h"

namespace test_rounding_compensation {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::uint32_t side = 20, columns = 6;

// A square sheet of quads; its right half is `shrink` times as narrow. Six shapes, the last of which leaves a fifth of
// the vertices alone, on six controls.
FaceModel sheet(float shrink) {
  FaceModel model;
  for (std::uint32_t v = 0; v < side * side; ++v) {
    const float x = static_cast<float>(v % side), half = side / 2;
    for (const float axis : {x < half ? x : half + (x - half) / shrink, static_cast<float>(v / side), 0.0f})
      model.rest.points.push_back(axis);
  }
  add_grid_quads(model.rest, side);
  Random random(3);
  std::vector<float> values;
  for (std::uint32_t c = 0; c < columns; ++c) {
    model.schema.controls.push_back({std::string(1, char('a' + c)), 0, 1, 0, ""});
    model.network.features.push_back({.kind = FeatureKind::identity, .control = c, .scale = 1});
    model.network.direct.push_back(c);
    for (std::uint32_t row = 0; row < 3 * side * side; ++row) {
      const float x = static_cast<float>(row / 3 % side) / side, y = static_cast<float>(row / 3) / (side * side);
      const bool alone = c + 1 == columns && y < 0.2f;
      values.push_back(alone ? 0
                             : std::sin(3 * x + static_cast<float>(c)) * std::cos(4 * y) + random.uniform(-0.1f, 0.1f));
    }
  }
  model.basis = make_basis(3 * side * side, columns, values);
  return model;
}

// Poses in which all controls rise together, more or less.
std::vector<float> joint_poses(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<float> poses;
  for (std::size_t pose = 0; pose < count; ++pose) {
    const float all = random.uniform(0.0f, 1.0f);
    for (std::uint32_t c = 0; c < columns; ++c) poses.push_back(all * random.uniform(0.7f, 1.0f));
  }
  return poses;
}

// Mean squared distance of coordinates between the basis and what is packed of it.
double error(const FaceModel& model, const PackedModel& packed, const std::vector<float>& poses) {
  double sum = 0;
  for (std::size_t b = 0; b < packed.row_blocks.size(); ++b) {
    const RowBlock& exact = model.basis.row_blocks[b];
    const PackedRowBlock& block = packed.row_blocks[b];
    std::vector<double> values(std::size_t(columns) * block.row_count);  // of all columns, less what is packed
    for (std::size_t c = 0; c < exact.columns.size(); ++c)
      std::copy_n(exact.values.begin() + static_cast<std::ptrdiff_t>(c * block.row_count), block.row_count,
                  values.begin() + static_cast<std::ptrdiff_t>(exact.columns[c] * block.row_count));
    for (std::size_t c = 0; c < block.columns.size(); ++c)
      for (std::uint32_t row = 0; row < block.row_count; ++row)
        values[block.columns[c].column * block.row_count + row] -=
            double(block.values[c * block.row_count + row]) * block.columns[c].scale;
    for (std::size_t pose = 0; pose < poses.size(); pose += columns)
      for (std::uint32_t row = 0; row < block.row_count; ++row) {
        double off = 0;
        for (std::uint32_t c = 0; c < columns; ++c) off += poses[pose + c] * values[c * block.row_count + row];
        sum += off * off;
      }
  }
  return sum / static_cast<double>(poses.size() / columns * packed.rest.points.size());
}

}  // namespace

TEST_CASE("columns that are active together make good each other's rounding errors") {
  const FaceModel model = sheet(1);
  PackOptions packing;
  packing.step = 0.01;
  packing.step_lambda = 1e6;  // rounds to nearest
  const PackedModel plain = pack_model(model, packing);
  packing.samples = joint_poses(1, 300);
  const PackedModel compensated = pack_model(model, packing);
  const std::vector<float> unseen = joint_poses(2, 100);
  CHECK(error(model, compensated, unseen) < 0.5 * error(model, plain, unseen));
  for (const int threads : {1, 3}) {
    const PackedModel again = pack_model(model, packing, {.threads = threads});
    for (std::size_t b = 0; b < again.row_blocks.size(); ++b)
      CHECK(again.row_blocks[b].values == compensated.row_blocks[b].values);
  }
  // A vertex that a shape leaves alone stays where it is.
  for (const PackedRowBlock& block : compensated.row_blocks)
    for (std::size_t c = 0; c < block.columns.size(); ++c)
      for (std::uint32_t row = 0; row < block.row_count && block.columns[c].column + 1 == columns; ++row)
        if ((block.first_row + row) / 3 < side * side / 5) CHECK(block.values[c * block.row_count + row] == 0);
  // Without the best rounding, row blocks have the same columns.
  packing.rate_distortion = false;
  const PackedModel quick = pack_model(model, packing);
  const auto same = [](const PackedColumn& a, const PackedColumn& b) {
    return a.column == b.column && a.wide == b.wide && a.scale == b.scale;
  };
  for (std::size_t b = 0; b < quick.row_blocks.size(); ++b)
    CHECK(std::ranges::equal(quick.row_blocks[b].columns, compensated.row_blocks[b].columns, same));
  packing.samples.pop_back();
  CHECK_THROWS_WITH(pack_model(model, packing), "1799 samples of 6 coefficients");
}

TEST_CASE("a column is rounded from what the errors before it leave") {
  PackedModel packed;
  packed.columns = 3;
  packed.row_blocks.push_back({0, 3, {{0, false, 1}, {1, false, 1}, {2, false, 1}}, std::pmr::vector<std::int16_t>(9)});
  // The second coefficient is twice the first, the third never active.
  const RoundingCompensation compensation(packed, std::vector<float>{1, 2, 0, 2, 4, 0, -1, -2, 0}, {}, {});
  REQUIRE(compensation.factors(0, 1).size() == 1);
  CHECK(compensation.factors(0, 1)[0] ==
        doctest::Approx(4 / (8 * 1.1 + 0.03)));  // an error e of the first is about -e / 2 of the second
  CHECK(compensation.factors(0, 2)[0] == 0);
  CHECK(compensation.factors(0, 2)[1] == 0);
  // Sizes whose squares are no floats.
  const RoundingCompensation large(packed, std::vector<float>{1e30f, 2e30f, 0, 3e38f, 3e38f, 1e-30f}, {}, {});
  for (const float factor : large.factors(0, 2)) CHECK(std::isfinite(factor));
}

TEST_CASE("a column that poses barely use makes good nothing") {
  PackedModel packed;
  packed.columns = 2;
  packed.row_blocks.push_back({0, 3, {{0, false, 1}, {1, false, 1}}, std::pmr::vector<std::int16_t>(6)});
  // A corrective that is a thousandth of what it may be, in one pose of a hundred.
  std::vector<float> samples;
  for (int pose = 0; pose < 100; ++pose) samples.insert(samples.end(), {0.5f, pose == 0 ? 1e-4f : 0});
  const RoundingCompensation compensation(packed, samples, std::vector<float>{0.5f, 0.1f}, {});
  // In units of typical sizes, an error of the first moves less than a thousandth of it to the second.
  CHECK(std::fabs(compensation.factors(0, 1)[0]) < 1e-3f * 0.5f / 0.1f);
}

TEST_CASE("steps are finer where vertices lie densely") {
  const std::vector<float> spacing = vertex_spacing(sheet(8).rest);
  const float wide = spacing[5 * side + 3], narrow = spacing[5 * side + side - 4];
  CHECK(wide / narrow == doctest::Approx(std::sqrt(8)));
  CHECK(vertex_spacing(Mesh()).empty());
  Mesh lonely;
  lonely.points = {0, 0, 0};
  CHECK(vertex_spacing(lonely) == std::vector<float>{1});

  // Two row blocks: the wide half and the narrow one.
  FaceModel model = sheet(8);
  model.basis.order.clear();
  for (const bool right : {false, true})
    for (std::uint32_t v = 0; v < side * side; ++v)
      if ((v % side >= side / 2) == right) model.basis.order.push_back(v);
  constexpr std::uint32_t rows = 3 * side * side / 2;
  model.basis.row_blocks.clear();
  for (const std::uint32_t first : {0u, rows}) {
    RowBlock& block = model.basis.row_blocks.emplace_back(RowBlock{first, rows, {}, {}});
    for (std::uint32_t c = 0; c < columns; ++c) {
      block.columns.push_back(c);
      for (std::uint32_t row = 0; row < rows; ++row) block.values.push_back(std::sin(float(row / 3 + c)));
    }
  }
  PackOptions packing;
  packing.step = 0.01;
  const PackedModel same = pack_model(model, packing);
  packing.normal_weight = 1;
  const PackedModel finer = pack_model(model, packing);
  for (std::uint32_t c = 0; c < columns; ++c) {
    CHECK(same.row_blocks[0].columns[c].scale == same.row_blocks[1].columns[c].scale);
    const float ratio = finer.row_blocks[0].columns[c].scale / finer.row_blocks[1].columns[c].scale;
    CHECK(ratio >= 2);
    CHECK(std::log2(ratio) == std::round(std::log2(ratio)));
  }
}

}  // namespace test_rounding_compensation
