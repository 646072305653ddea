// The kernels of every instruction set against the definition and the scalar kernels.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/status.h"
#include "model/packed_model.h"
#include "runtime/instruction_set.h"
#include "runtime/panel_matrix.h"

namespace test_kernels {

using namespace fb;
using namespace fb::runtime;

namespace {

struct Inputs {
  std::size_t poses;
  std::vector<std::uint32_t> indices = {}, offsets = {};
  std::vector<std::int16_t> values = {};
  std::vector<std::uint32_t> initial_sums = {};
  PanelInputs panel_inputs() const {
    return {offsets.data(), values.data(), indices.size(), poses, initial_sums.data()};
  }
  std::int16_t at(std::size_t column, std::size_t pose) const {
    return values[(column / 4 * poses + pose) * 4 + column % 4];
  }
};

// Inputs of `count` random columns, or of all columns for quads, padded to a multiple of 4. kind 0: the largest values,
// 1: the smallest, 2: values near 0, else any.
Inputs some_inputs(Random& random, std::size_t poses, std::size_t count, const PanelMatrix& matrix, bool quads,
                   int kind) {
  const auto columns = static_cast<std::uint32_t>(matrix.columns());
  if (quads) count = columns;
  Inputs inputs{poses};
  inputs.values.reserve(4 * poses);
  for (std::uint32_t i = 0; i < (count + 3) / 4 * 4; ++i)
    inputs.indices.push_back(i >= count ? 0 : quads ? i : random.below(columns));
  for (const std::uint32_t i : inputs.indices) inputs.offsets.push_back(quads ? 0 : matrix.offset(i));
  inputs.values.resize(inputs.indices.size() * poses);
  for (std::size_t pose = 0; pose < poses; ++pose) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const int any = int(random.below(2 * largest_wide + 1)) - largest_wide;
      const int value = kind == 0   ? largest_wide
                        : kind == 1 ? -largest_wide
                        : kind == 2 ? int(random.below(513)) - 256
                                    : any;
      inputs.values[(i / 4 * poses + pose) * 4 + i % 4] = static_cast<std::int16_t>(value);
      sum += static_cast<std::uint32_t>(value);
    }
    inputs.initial_sums.push_back(0 - 128 * sum);
  }
  return inputs;
}

}  // namespace

TEST_CASE("panel products are exact, for matrices of both forms, all sizes and all kinds of inputs") {
  using enum PanelMatrix::Form;
  constexpr float mark = 12345;
  Random random(4);
  for (const PanelMatrix::Form form : {columns, quads})
    for (const std::uint32_t rows : {1u, 16u, 17u, 32u, 40u, 48u, 63u, 64u, 65u, 96u, 112u, 150u, 192u, 250u, 300u})
      for (const std::uint32_t width : {1u, 5u, 60u}) {
        std::vector<int> digits(std::size_t(rows) * width);
        for (int& digit : digits) digit = int(random.below(256)) - 128;
        digits[0] = -128;
        digits[digits.size() - 1] = 127;
        std::vector<PanelMatrix> matrices;
        for (const PoseKernels* kernels : runnable_kernels()) {
          PanelMatrix& matrix = matrices.emplace_back(*kernels, form, rows, width, *std::pmr::get_default_resource());
          for (std::uint32_t r = 0; r < rows; ++r) {
            const std::vector<std::int16_t> row(digits.begin() + r * width, digits.begin() + (r + 1) * width);
            matrix.set_row(r, row.data(), {});
          }
          matrix.find_limit();
          bool kept = matrix.limit() == matrices.front().limit();
          for (std::uint32_t r = 0; r < rows; ++r)
            for (std::uint32_t c = 0; c < width; ++c) kept = kept && matrix.digit(r, c) == digits[r * width + c];
          CHECK_MESSAGE(kept, kernels->name);
        }
        std::vector<float> scales(rows + padding), bias(rows + padding);
        for (std::uint32_t r = 0; r < rows; ++r)
          scales[r] = 1 / float(1 + random.below(1000)), bias[r] = float(random.below(100));
        for (int kind = 0; kind < 4; ++kind)
          for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 30u})
            for (const std::size_t poses : {std::size_t{1}, poses_per_block}) {
              if (form == quads && count > 0) continue;
              const Inputs inputs = some_inputs(random, poses, count, matrices.front(), form == quads, kind);
              const std::vector<float> steps(poses, 1 / float(1 + random.below(1000)));
              const bool scaled = random.below(2) != 0;
              // Only kinds that keep sums small show every bit of them.
              std::vector<std::vector<float>> expected(poses, std::vector<float>(rows + 1, mark));
              for (std::size_t pose = 0; pose < poses; ++pose)
                for (std::uint32_t r = 0; r < rows; ++r) {
                  std::int64_t sum = 0;
                  for (std::size_t k = 0; k < inputs.indices.size(); ++k)
                    sum += std::int64_t(inputs.at(k, pose)) * digits[r * width + inputs.indices[k]];
                  const float factor = (scaled ? scales[r] : 1) * steps[pose];
                  expected[pose][r] = factor * static_cast<float>(static_cast<std::int32_t>(sum)) + bias[r];
                }
              for (std::size_t m = 0; m < matrices.size(); ++m) {
                std::vector<std::vector<float>> found(poses, std::vector<float>(rows + 1, mark));
                const PanelMatrix& matrix = matrices[m];
                for (std::uint32_t first = 0; first < rows; first += matrix.panel_rows()) {
                  float* to[poses_per_block];
                  for (std::size_t pose = 0; pose < poses; ++pose) to[pose] = found[pose].data() + first;
                  matrix.multiply(first, inputs.panel_inputs(),
                                  {scaled ? scales.data() + first : nullptr, bias.data() + first, steps.data(), to});
                }
                CHECK_MESSAGE(found == expected, runnable_kernels()[m]->name
                                                     << (form == quads ? ", quads: " : ", columns: ") << rows << " x "
                                                     << width << ", kind " << kind << ", " << poses << " poses");
              }
            }
      }
}

TEST_CASE("kernels clamp controls, compute features and compact non-zeros as the scalar ones do") {
  Random random(6);
  for (const std::size_t controls : {std::size_t(1), std::size_t(15), std::size_t(70)}) {
    std::vector<float> minimum, maximum, rest;
    for (std::size_t c = 0; c < controls; ++c) {
      minimum.push_back(random.uniform(-2, 0));
      maximum.push_back(random.uniform(0, 2));
      rest.push_back(random.below(2) ? 0 : minimum.back());
    }
    std::vector<std::uint32_t> of;
    std::vector<FeatureKind> kinds;
    std::vector<float> scales, thresholds, falls;
    for (std::size_t f = 0; f < 3 * controls; ++f) {
      of.push_back(static_cast<std::uint32_t>(f / 3));
      kinds.push_back(static_cast<FeatureKind>(random.below(3)));
      scales.push_back(f % 7 == 0 ? 3e38f : random.uniform(-3, 3));
      thresholds.push_back(random.uniform(0, 1));
      falls.push_back(random.uniform(0, 2));
    }
    const ControlFeatures features = {of.data(),         kinds.data(), scales.data(),
                                      thresholds.data(), falls.data(), of.size()};
    for (const std::size_t poses : {std::size_t{1}, poses_per_block}) {
      std::vector<float> values(controls * poses);
      for (float& value : values) value = random.below(4) ? random.uniform(-3, 3) : 0;
      values[0] = INFINITY;
      const auto run = [&](const PoseKernels& kernels) {
        std::vector<float> results(controls * poses + of.size() * poses);
        float* const offsets = results.data();
        std::uint32_t clamped = 0;
        for (std::size_t p = 0; p < poses; ++p)
          clamped += kernels.clamp_controls(values.data() + p * controls, minimum.data(), maximum.data(), rest.data(),
                                            controls, offsets + p, poses);
        float* const found = offsets + controls * poses;
        kernels.control_features(features, offsets, poses, found);
        std::vector<std::uint32_t> indices(of.size() * poses + 16);
        const std::size_t active = kernels.compact_nonzeros(found, of.size() * poses, indices.data());
        indices.resize(active);
        indices.push_back(clamped);
        return std::pair(results, indices);
      };
      const auto [expected, listed] = run(scalar_kernels);
      CHECK(listed.back() > 0);
      for (std::size_t i = 0, next = 0; i < of.size() * poses; ++i)
        if (expected[controls * poses + i] != 0) CHECK(listed[next++] == i);
      for (const PoseKernels* kernels : runnable_kernels()) {
        const auto [results, indices] = run(*kernels);
        const bool same = std::memcmp(results.data(), expected.data(), expected.size() * sizeof(float)) == 0;
        CHECK_MESSAGE((same && indices == listed), kernels->name << ": " << controls << " controls, " << poses);
      }
    }
  }
}

TEST_CASE("kernels detect NaN") {
  for (const PoseKernels* kernels : runnable_kernels())
    for (const std::size_t count : {std::size_t(1), std::size_t(16), std::size_t(37)}) {
      std::vector<float> numbers(count, INFINITY);
      CHECK(!kernels->any_nan(numbers.data(), count));
      for (const std::size_t at : {std::size_t(0), count / 2, count - 1}) {
        numbers[at] = -NAN;
        CHECK(kernels->any_nan(numbers.data(), count));
        numbers[at] = 0;
      }
    }
}

TEST_CASE("kernels quantise numbers as the scalar ones do, whatever the padding holds") {
  Random random(7);
  for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 50u, 64u})
    for (const float limit : {1.0f, 77.0f, 32512.0f})
      for (const bool wild : {false, true}) {
        std::vector<float> numbers(count + padding, 1e30f);
        for (std::size_t i = 0; i < count; ++i) numbers[i] = random.uniform(-3, 3);
        if (wild && count > 15) numbers[3] = INFINITY, numbers[4] = -NAN, numbers[5] = -1e-38f, numbers[6] = -INFINITY;
        std::vector<std::int16_t> expected(count + padding, -1), found(count + padding, -1);
        const Quantisation one = scalar_kernels.quantise(numbers.data(), count, limit, expected.data());
        for (const PoseKernels* kernels : runnable_kernels()) {
          std::fill(found.begin(), found.end(), std::int16_t(-1));
          const Quantisation other = kernels->quantise(numbers.data(), count, limit, found.data());
          CHECK_MESSAGE((other.step == one.step && other.sum == one.sum && found == expected),
                        kernels->name << ": " << count << " numbers, limit " << limit);
        }
      }
}

TEST_CASE("kernels quantise a block of poses as single poses") {
  Random random(5);
  for (const PoseKernels* kernels : runnable_kernels())
    for (const std::size_t count : {0u, 1u, 4u, 21u, 64u}) {
      std::vector<float> side_by_side(poses_per_block * (count + padding));
      for (float& number : side_by_side) number = random.uniform(-3, 3);
      for (std::size_t i = 0; i < count; ++i) side_by_side[i * poses_per_block + 1] = 0;
      if (count > 1) side_by_side[2] = INFINITY, side_by_side[3] = NAN, side_by_side[12] = 1e-38f;
      std::vector<std::int16_t> quantised((count + 3) / 4 * 4 * poses_per_block), ones(count + padding);
      Quantisation block[poses_per_block];
      kernels->quantise_block(side_by_side.data(), count, 32512, quantised.data(), block);
      for (std::size_t pose = 0; pose < poses_per_block; ++pose) {
        std::vector<float> numbers(count + padding);
        for (std::size_t i = 0; i < count; ++i) numbers[i] = side_by_side[i * poses_per_block + pose];
        std::fill(ones.begin(), ones.end(), std::int16_t(0));
        const Quantisation one = scalar_kernels.quantise(numbers.data(), count, 32512, ones.data());
        bool same = block[pose].step == one.step && block[pose].sum == one.sum;
        for (std::size_t i = 0; i < quantised.size() / poses_per_block; ++i)
          same = same && quantised[(i / 4 * poses_per_block + pose) * 4 + i % 4] == ones[i];
        CHECK_MESSAGE(same, kernels->name << ": " << count << " numbers, pose " << pose);
      }
    }
}

TEST_CASE("kernels move groups of vertices by joints as single vertices") {
  constexpr std::uint32_t joints = 6, vertices = SkinGroup::vertices;
  Random random(3);
  std::vector<JointMatrix> matrices(joints);
  for (std::size_t j = 1; j < joints; ++j)  // the first did not move
    for (std::size_t i = 0; i < joint_matrix_floats; ++i)
      matrices[j].numbers[i] = i % 4 < 3 ? random.uniform(-1, 1) : 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    SkinGroup group{9, round % SkinGroup::most_joints + 1, {}, 8};
    std::vector<float> weights(8 + SkinGroup::most_joints * vertices);
    std::vector<std::uint32_t> first = {0, 0, 0, 0};  // three vertices before the group
    std::vector<JointInfluence> influences;
    for (std::uint32_t j = 0; j < group.joints; ++j) group.offset[j] = joint_matrix_floats * ((round + 5 * j) % joints);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      for (std::uint32_t j = 0; j < group.joints; ++j) {
        if (random.below(3) == 0) continue;
        weights[8 + j * vertices + v] = random.uniform(0, 1);
        influences.push_back({group.offset[j], weights[8 + j * vertices + v]});
      }
      first.push_back(static_cast<std::uint32_t>(influences.size()));
    }
    std::vector<float> rows(9 + 3 * vertices + 4);
    for (float& row : rows) row = random.below(4) == 0 ? -0.0f : random.uniform(-9, 9);
    std::vector<float> expected = rows;
    scalar_kernels.skin_vertices({first.data(), influences.data()}, 3, 3 + vertices, matrices[0].numbers,
                                 expected.data());
    for (const PoseKernels* kernels : runnable_kernels()) {
      std::vector<float> found = rows;
      kernels->skin_groups(&group, 1, weights.data(), matrices[0].numbers, found.data());
      CHECK_MESSAGE(std::memcmp(found.data(), expected.data(), found.size() * sizeof(float)) == 0,
                    kernels->name << ": " << group.joints << " joints");
    }
  }
}

TEST_CASE("an instruction set is chosen by name or by the processor's features") {
  const auto runnable = runnable_kernels();
  REQUIRE(!runnable.empty());
  CHECK(runnable.front() == &scalar_kernels);
  CHECK(&choose_kernels("scalar") == &scalar_kernels);
  for (const PoseKernels* kernels : runnable) {
    const std::string name = choose_kernels(kernels->name).name;
    // The environment may cap a test run too.
    if (!std::getenv(instruction_set_variable)) CHECK(name == kernels->name);
  }
  if (!std::getenv(instruction_set_variable)) CHECK(&choose_kernels() == runnable.back());
  CHECK(&choose_kernels("") == &choose_kernels());
  CHECK_THROWS_WITH_AS(choose_kernels("mmx"), doctest::Contains("instruction set: \"mmx\" is not one of scalar"),
                       Error);
}

}  // namespace test_kernels
