#include "golden_arithmetic.h"

#include <algorithm>
#include <vector>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/random.h"
#include "test_models.h"

namespace fb {
namespace {

// Each rule is in a row block of its own.
PackedModel arithmetic() {
  using Kind = Feature::Kind;
  constexpr std::uint32_t many = 1040;
  PackedModel model = tiny_packed_model();
  model.order.clear();
  model.schema.controls = {
      {"rounded", 0, 1, 0.3f, ""}, {"vast", 0, 1e10f, 0, ""}, {"even", -2, 2, 0, ""}, {"d", 0, 1, 0, ""}};
  model.features = {{Kind::identity, 0, 0.7f},         {Kind::identity, 2, 1},
                    {Kind::identity, 2, 0.5f / 32512}, {Kind::identity, 2, 1.5f / 32512},
                    {Kind::identity, 2, 2.5f / 32512}, {Kind::identity, 2, 3.5f / 32512},
                    {Kind::identity, 1, 1e38f},        {Kind::identity, 3, 1},
                    {Kind::product, 0, 1, 0, 0, 6, 7}, {Kind::identity, 3, 1e-35f}};
  const auto first = static_cast<std::uint32_t>(model.features.size());
  for (std::uint32_t i = 0; i < many; ++i)
    model.features.push_back({Kind::identity, 3, (i % 3 != 0 ? 1.0f : -1.0f) * float(i + 1) / float(many)});
  model.direct.clear();
  for (std::uint32_t f = 0; f < model.features.size(); ++f) model.direct.push_back(f);
  Random random(5);
  PackedLayer tanh = {
      1, 4, Activation::tanh, false, false, {10, 60, 120, 127}, {0.025f, 0.0166f, 0.041f, 0.16f}, {0, 0.1f, 0, 0}};
  PackedLayer hidden = {3,
                        16,
                        Activation::tanh,
                        false,
                        false,
                        random_numbers(random, 48, 127),
                        std::vector<float>(16, 0.1f),
                        random_values(random, 16, 9)};
  PackedLayer wide = {
      16,       3, Activation::linear, false, true, random_numbers(random, 48, 32000), std::vector<float>(3, 1e-4f),
      {0, 0, 0}};
  for (std::size_t i = 0; i < 16; ++i) wide.weights[i] = static_cast<std::int16_t>(31000 + i);
  for (std::size_t i = 0; i < 16; ++i) hidden.bias[i] = 9;
  model.regions = {{"tanh", {1}, {tanh}, {}}, {"wide", {0, 1, 7}, {hidden, wide}, {}}};
  const auto regions = static_cast<std::uint32_t>(model.direct.size());
  model.columns = regions + 7;
  model.row_blocks.clear();
  const auto add = [&](const std::vector<std::uint32_t>& columns, std::int16_t value) {
    const auto row = static_cast<std::uint32_t>(3 * model.row_blocks.size());
    PackedRowBlock block = {row, 3, {}, {}};
    for (const std::uint32_t column : columns) {
      block.columns.push_back({column, false, 1});
      block.values.insert(block.values.end(), {value, static_cast<std::int16_t>(-value), 1});
    }
    model.row_blocks.push_back(block);
  };
  add({0}, 101);
  add({1, 2, 3, 4, 5}, 1);
  add({1, 8}, 3);
  add({9}, 127);
  std::fill_n(model.rest.points.begin() + 9, 3, 0.0f);
  for (std::uint32_t t = 0; t < 4; ++t) add({regions + t}, 3);
  add({regions + 4, regions + 5, regions + 6}, 2);
  // 1,032 x 127 + 8 = 2^17, of which 2^31 is a multiple.
  std::vector<std::uint32_t> columns(many);
  for (std::uint32_t i = 0; i < many; ++i) columns[i] = first + i;
  add(columns, 127);
  for (std::size_t i = 1032; i < many; ++i)
    for (std::size_t r = 0; r < 3; ++r) model.row_blocks.back().values[3 * i + r] = i == 1032 ? 8 : 0;
  model.row_blocks.push_back({30, 60, {}, {}});
  model.expected.unit = 0.5f;
  model.expected.regions = {{"all", 0.25f}};
  model.expected.runs = {{30, 0}};
  model.expected.weights = {200, 201, 202, 203};
  model.expected.trained_low.assign(4, 0);
  model.expected.trained_high.assign(4, 255);
  model.expected.untrained_pairs.resize(pair_bytes(4));
  model.expected.set_untrained(0, 2);
  return model;
}

}  // namespace

Bytes archive_of_arithmetic() {
  const PackedModel model = arithmetic();
  std::vector<float> poses = {0.3f, 0, 0, 0, 0.77f, 0, 1, 0, 0.1f, 1e10f, 1, 0, 5, 2e10f, -7, 3, 0.51f, 0, 0.6f, 0};
  Random random(6);
  for (int pose = 0; pose < 12; ++pose)
    poses.insert(poses.end(), {random.uniform(), 0, random.uniform(-2, 2), random.uniform()});
  return archive::write_archive(model, bake::prove_poses(model, poses), {});
}

}  // namespace fb
