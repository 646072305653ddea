#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "base/memory_budget.h"
#include "base/status.h"
#include "plain_face.h"
#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_evaluator {

using namespace fb;
using namespace fb::runtime;

namespace {

// A face of realistic size: deep skip layers, global and local columns, odd widths, combined features, gates.
PackedModel wide_model(std::uint64_t seed = 7) {
  PackedModel model = tiny_packed_model();
  Random random(seed);
  model.schema.controls.clear();
  model.features.clear();
  using Kind = Feature::Kind;
  for (std::uint32_t c = 0; c < 90; ++c) {
    model.schema.controls.push_back({"control" + std::to_string(c), -1, 1, c % 3 == 0 ? 0.5f : 0.0f, ""});
    model.features.push_back({Kind::identity, c, 0.5f});
    model.features.push_back({c % 2 ? Kind::ramp : Kind::hat, c, c % 4 < 2 ? 1.0f : -1.0f, 0.25f, float(c % 3)});
  }
  for (std::uint32_t f = 0; f < 40; ++f)
    model.features.push_back({f % 2 ? Kind::product : Kind::minimum, 0, 1, 0, 0, random.below(180 + f), f});
  PackedRegion region{"whole", {}, {}, {}}, small{"part", {}, {}, {{0, 2, 10, 40}, random.uniform(0.5f, 3)}};
  for (std::uint32_t f = 0; f < 220; ++f) (f % 8 ? region : small).features.push_back(f);
  const auto layer = [&](std::size_t inputs, std::uint32_t outputs, Activation activation, bool skip, bool wide) {
    PackedLayer packed =
        random_packed_layer(random, static_cast<std::uint32_t>(inputs), outputs, activation, skip, wide);
    for (float& scale : packed.scales) scale *= 6 / std::sqrt(float(inputs));
    return packed;
  };
  using enum Activation;
  region.layers = {layer(region.features.size(), 130, silu, false, true), layer(130, 130, relu, true, false),
                   layer(130, 130, tanh, true, true), layer(130, 37, linear, false, false)};
  small.layers = {layer(small.features.size(), 20, relu, false, false), layer(20, 17, linear, false, true)};
  model.direct = {5, 8, 5, 180, 181, 219};
  model.regions = {region, small};
  model.columns = 60;
  model.rest = grid_mesh(23, 17, seed);
  model.rest.points[4] = -0.0f;
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  model.row_blocks.clear();
  for (std::uint32_t first = 0; first < rows;) {
    const std::uint32_t count = std::min(40 + random.below(100), rows - first);
    std::vector<std::uint32_t> columns;
    for (std::uint32_t column = 0; column < 60; ++column)
      if (column % 4 == 0 || random.uniform() < 0.3f) columns.push_back(column);
    model.row_blocks.push_back(random_row_block(random, first, count, columns, 0.3f));
    vary_wide_columns(model.row_blocks.back(), random);
    first += count;
  }
  model.order.clear();
  for (std::uint32_t i = 0; i < model.rest.vertex_count(); ++i)
    model.order.push_back((5 * i + 3) % static_cast<std::uint32_t>(model.rest.vertex_count()));
  return model;
}

PackedModel in_order(PackedModel model) {
  model.order.clear();
  return model;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::vector<float> evaluate(const Evaluator& evaluator, const std::vector<float>& controls) {
  Workspace workspace(evaluator);
  std::vector<float> positions(3 * evaluator.vertex_count());
  evaluator.evaluate(controls.data(), positions.data(), workspace);
  return positions;
}

}  // namespace

TEST_CASE("poses agree with the definition bit for bit") {
  for (const PackedModel& model : {tiny_packed_model(), tiny_packed_model(2), in_order(tiny_packed_model(3)),
                                   wide_model(), wide_model(8), in_order(wide_model(9))}) {
    const Evaluator evaluator(model);
    Workspace workspace(evaluator);
    Random random(3);
    double moved = 0;
    for (int n = 0; n < 25; ++n) {
      std::vector<float> pose = random_pose(model.schema, random), weights(evaluator.coefficient_count());
      for (std::size_t c = 0; c < pose.size(); ++c)  // from dense to sparse, and at the ends of ranges
        if (random.uniform() < 0.04f * float(n)) pose[c] = model.schema.controls[c].rest;
      if (n % 3 == 0) pose[0] = 9;
      const std::vector<float> positions = evaluate(evaluator, pose);
      CHECK(same_bits(positions, plain::positions(model, pose)));
      evaluator.coefficients(pose.data(), weights.data(), workspace);
      CHECK(same_bits(weights, plain::coefficients(model, pose)));
      for (std::size_t i = 0; i < positions.size(); ++i)
        moved = std::max(moved, std::fabs(double(positions[i]) - model.rest.points[i]));
    }
    CHECK(moved > 0.02 * model.rest.diagonal());
  }
}

TEST_CASE("integer sums never overflow, whatever the weights") {
  // Rows of extreme digits, long enough that the largest inputs would overflow 32 bits.
  for (const std::uint32_t inputs : {515u, 521u, 700u, 3000u})
    for (const bool wide : {false, true}) {
      PackedModel model = tiny_packed_model();
      Random random(inputs);
      model.regions.resize(1);
      PackedRegion& region = model.regions[0];
      region.features.assign(inputs, 0);
      const int most = wide ? 127 * 256 - 128 : largest_narrow;  // both digits extreme
      PackedLayer first{inputs, 4, Activation::linear, false, wide, {}, {1e-6f, 1e-6f, 1e-6f, 1e-6f}, {0, 1, 2, 3}};
      for (std::uint32_t o = 0; o < 4; ++o)
        for (std::uint32_t i = 0; i < inputs; ++i)
          first.weights.push_back(static_cast<std::int16_t>(o == 0   ? most
                                                            : o == 1 ? -most
                                                            : o == 2 ? (i % 2 ? most : -most)
                                                                     : int(random.below(250)) - 125));
      region.layers = {first, random_packed_layer(random, 4, 2, Activation::linear, false, false)};
      model.columns = 4;
      for (PackedRowBlock& block : model.row_blocks) {
        block.columns.resize(3);
        for (std::uint32_t c = 0; c < 3; ++c) block.columns[c].column = c + 1;
        block.values.resize(std::size_t(3) * block.row_count);
        for (std::size_t i = 0; i < block.values.size(); ++i)
          if (!block.columns[i / block.row_count].wide)
            block.values[i] = std::clamp<std::int16_t>(block.values[i], -127, 127);
      }
      const Evaluator evaluator(model);
      for (const float jaw : {1.0f, 0.37f, 0.0f}) {
        std::vector<float> pose = model.schema.rest_pose();
        pose[0] = jaw;
        CHECK(same_bits(evaluate(evaluator, pose), plain::positions(model, pose)));
      }
    }
}

TEST_CASE("infinities and NaN within the model have a defined result") {
  for (const float huge : {1e30f, 1e38f}) {
    PackedModel model = wide_model();
    for (std::size_t f = 0; f < model.features.size(); f += 5) model.features[f].scale = huge;
    for (float& scale : model.regions[0].layers[1].scales) scale = huge;
    for (PackedRowBlock& block : model.row_blocks) block.columns[0].scale = huge * 1e-3f;
    const Evaluator evaluator(model);
    Random random(11);
    for (int n = 0; n < 5; ++n) {
      const std::vector<float> pose = random_pose(model.schema, random), positions = evaluate(evaluator, pose);
      CHECK(same_bits(positions, plain::positions(model, pose)));
      CHECK(std::none_of(positions.begin(), positions.end(), [](float p) { return p != p; }));
    }
  }
}

TEST_CASE("a gate is closed while only one control is moved") {
  const PackedModel model = tiny_packed_model();
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  std::vector<float> weights(evaluator.coefficient_count()), pose = model.schema.rest_pose();
  pose[3] = 1.5f;
  evaluator.coefficients(pose.data(), weights.data(), workspace);
  CHECK(weights[4] == 0);
  pose[1] = 0.5f;
  evaluator.coefficients(pose.data(), weights.data(), workspace);
  CHECK(weights[4] != 0);
}

TEST_CASE("controls at rest give the rest mesh to the last bit and no coefficients") {
  for (const PackedModel& model : {tiny_packed_model(), wide_model(), in_order(wide_model())}) {
    const Evaluator evaluator(model);
    CHECK(same_bits(evaluate(evaluator, model.schema.rest_pose()), model.rest.points));
    Workspace workspace(evaluator);
    std::vector<float> coefficients(evaluator.coefficient_count(), 1.0f);
    evaluator.coefficients(model.schema.rest_pose().data(), coefficients.data(), workspace);
    CHECK(std::all_of(coefficients.begin(), coefficients.end(), [](float c) { return c == 0; }));
  }
}

TEST_CASE("coefficients are the weights of the basis' columns") {
  const PackedModel model = wide_model();
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  Random random(4);
  const std::vector<float> pose = random_pose(model.schema, random), positions = evaluate(evaluator, pose);
  std::vector<float> weights(evaluator.coefficient_count());
  evaluator.coefficients(pose.data(), weights.data(), workspace);
  std::vector<double> sum(model.rest.points.begin(), model.rest.points.end());
  for (const PackedRowBlock& block : model.row_blocks)
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const std::vector<float> moved = displacements(block, c);
      for (std::uint32_t r = 0; r < block.row_count; ++r)
        sum[model.coordinate(block.first_row + r)] += double(weights[block.columns[c].column]) * moved[r];
    }
  for (std::size_t i = 0; i < sum.size(); ++i)  // up to the rounding of coefficients
    CHECK(std::fabs(positions[i] - sum[i]) < 1e-4 * model.rest.diagonal());
}

TEST_CASE("positions follow slow motion: a wide column is rounded as finely as its values allow") {
  PackedModel model = tiny_packed_model();
  Random random(3);
  constexpr float reach = 0.5f;  // of every column, for one unit of its coefficient
  for (PackedRowBlock& block : model.row_blocks) {
    for (PackedColumn& column : block.columns) column = {column.column, true, reach / float(largest_wide)};
    vary_wide_columns(block, random);
  }
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  const std::vector<float> from = random_pose(model.schema, random), to = random_pose(model.schema, random);
  double worst = 0;
  for (int frame = 0; frame < 100; ++frame) {
    std::vector<float> pose = from;
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] += 1e-4f * float(frame) * (to[c] - from[c]);
    std::vector<float> weights(evaluator.coefficient_count());
    evaluator.coefficients(pose.data(), weights.data(), workspace);
    const std::vector<float> positions = evaluate(evaluator, pose);
    float largest_weight = 0;
    for (const float weight : weights) largest_weight = std::max(largest_weight, std::fabs(weight));
    std::vector<double> exact(model.rest.points.begin(), model.rest.points.end());
    std::size_t most_columns = 0;
    for (const PackedRowBlock& block : model.row_blocks) {
      most_columns = std::max(most_columns, block.columns.size());
      for (std::size_t c = 0; c < block.columns.size(); ++c) {
        const std::vector<float> moved = displacements(block, c);
        for (std::uint32_t r = 0; r < block.row_count; ++r)
          exact[model.coordinate(block.first_row + r)] += double(weights[block.columns[c].column]) * moved[r];
      }
    }
    // A summand is off by half a step at most. The largest digit of a column is 64 or more, so the largest summand is
    // at most a 64th of what its column moves, and a step a 32,512th of that.
    const double step = reach * largest_weight / 64 / 32512, digits = 127 + 128;
    const double bound = double(most_columns) * digits * step / 2;
    for (std::size_t i = 0; i < exact.size(); ++i) worst = std::max(worst, std::fabs(positions[i] - exact[i]) / bound);
  }
  CHECK(worst < 1);
  CHECK(worst > 0);
}

TEST_CASE("values outside their range are clamped and counted; NaN is refused by name") {
  const PackedModel model = tiny_packed_model();
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  std::vector<float> positions(model.rest.points.size());
  const std::vector<float> wild = {INFINITY, -3, 0.5f, 2, -0.5f}, within = {1, -1, 0.5f, 2, -0.5f};
  evaluator.evaluate(wild.data(), positions.data(), workspace);
  CHECK(workspace.clamped() == 2);
  CHECK(same_bits(positions, evaluate(evaluator, within)));
  evaluator.evaluate(within.data(), positions.data(), workspace);
  CHECK(workspace.clamped() == 0);

  const std::vector<float> bad = {0, 0, NAN, 0, 0}, before = positions;
  CHECK_THROWS_WITH_AS(evaluator.evaluate(bad.data(), positions.data(), workspace),
                       "control \"brow_raise\" is not a number", Error);
  CHECK(same_bits(positions, before));
}

TEST_CASE("a batch gives the bits of single poses for all strides, layouts and thread counts") {
  const PackedModel model = wide_model();
  const Evaluator evaluator(model);
  // Blocks of similar poses, of poses with few common features, and remaining poses; some of them at rest.
  const std::size_t poses = 3 * poses_per_block + 5;
  const std::size_t controls = evaluator.control_count(), vertices = evaluator.vertex_count();
  Random random(5);
  const std::size_t control_stride = controls + 3;
  std::vector<float> input(poses * control_stride, NAN);  // gaps between poses are not read
  std::vector<std::vector<float>> single;
  for (std::size_t p = 0; p < poses; ++p) {
    std::vector<float> pose = random_pose(model.schema, random);
    const std::size_t block = p / poses_per_block;
    for (std::size_t c = 0; c < controls; ++c)
      if (p % 5 == 4 || (block == 1 && c % 4 != 0) || (block == 2 && c % poses_per_block != p % poses_per_block))
        pose[c] = model.schema.controls[c].rest;
    std::copy(pose.begin(), pose.end(), input.begin() + p * control_stride);
    single.push_back(evaluate(evaluator, pose));
  }
  struct Layout {
    std::size_t pose_stride, vertex_stride;
  };
  for (const Layout layout : {Layout{0, 0}, Layout{4 * vertices + 5, 4}, Layout{3, 3 * poses}})
    for (const int threads : {1, 2, 5}) {
      std::vector<Workspace> workspaces;
      for (int w = 0; w < threads; ++w) workspaces.emplace_back(evaluator);
      const std::size_t pose_stride = layout.pose_stride ? layout.pose_stride : 3 * vertices;
      const std::size_t vertex_stride = layout.vertex_stride ? layout.vertex_stride : 3;
      std::vector<float> output((poses - 1) * pose_stride + (vertices - 1) * vertex_stride + 3, 77.0f);
      std::vector<float> expected = output;
      for (std::size_t p = 0; p < poses; ++p)
        for (std::size_t i = 0; i < 3 * vertices; ++i)
          expected[p * pose_stride + i / 3 * vertex_stride + i % 3] = single[p][i];
      evaluator.evaluate_batch(
          {poses, input, control_stride, {output.data(), output.size(), layout.pose_stride, layout.vertex_stride}},
          workspaces, {threads});
      CHECK(same_bits(output, expected));
    }
}

TEST_CASE("a batch that does not fit is refused before anything is written") {
  const PackedModel model = tiny_packed_model();
  const Evaluator evaluator(model);
  std::vector<Workspace> workspaces;
  workspaces.emplace_back(evaluator);
  std::vector<float> input(2 * 5, 0.0f), output(2 * 90, 7.0f);
  const std::vector<float> before = output;
  const auto refuses = [&](const Batch& batch) {
    CHECK_THROWS_AS(evaluator.evaluate_batch(batch, workspaces), Error);
    CHECK(same_bits(output, before));
  };
  const BatchOutput whole = {output.data(), output.size()};
  refuses({2, std::span(input).first(9), 0, whole});
  refuses({2, input, 0, {output.data(), 179}});
  refuses({2, input, 0, {output.data(), output.size(), 0, 2}});
  refuses({2, input, 0, {output.data(), output.size(), 89, 3}});
  refuses({2, input, 0, whole, {output.data(), 179}});
  refuses({2, input, SIZE_MAX / 2, whole});
  refuses({SIZE_MAX, input, 0, whole});
  const std::vector<std::uint8_t> mask(3, 1);
  refuses({.poses = 2, .controls = input, .positions = whole, .masks = {.regions = mask}});
  input[7] = NAN;
  refuses({2, input, 0, whole});
}

TEST_CASE("a host's scheduler that breaks its contract is detected") {
  const PackedModel model = tiny_packed_model();
  const Evaluator evaluator(model);
  std::vector<Workspace> workspaces;
  for (int w = 0; w < 2; ++w) workspaces.emplace_back(evaluator);
  std::vector<float> input(3 * 5, 0.0f), output(3 * 90);
  const auto run = [&](HostParallelFor host) {
    evaluator.evaluate_batch({3, input, 0, {output.data(), output.size()}}, workspaces, {2, host, nullptr});
  };
  run([](void*, std::uint32_t count, std::uint32_t workers, HostTask task, void* context) {
    for (std::uint32_t i = 0; i < count; ++i) task(context, i, i % workers);
  });
  CHECK_THROWS_AS(run([](void*, std::uint32_t, std::uint32_t, HostTask task, void* context) { task(context, 0, 0); }),
                  Error);
  CHECK_THROWS_AS(run([](void*, std::uint32_t count, std::uint32_t workers, HostTask task, void* context) {
                    for (std::uint32_t i = 0; i < count; ++i) task(context, i, workers);
                  }),
                  Error);
  CHECK_THROWS_AS(run([](void*, std::uint32_t count, std::uint32_t, HostTask task, void* context) {
                    for (std::uint32_t i = 0; i < count; ++i) task(context, i + 1, 0);
                  }),
                  Error);
}

TEST_CASE("a model beyond the memory limit, or one that overflows at rest, is refused") {
  PackedModel model = tiny_packed_model();
  const std::uint64_t bytes = Evaluator(model).bytes();
  CHECK(bytes > model.rest.points.size() * sizeof(float));
  MemoryBudget enough;
  CHECK(Evaluator(model, {nullptr, &enough}).bytes() == bytes);
  CHECK(enough.used() == 0);
  MemoryBudget just_enough(enough.peak()), too_little(enough.peak() - 1);
  CHECK_NOTHROW(Evaluator(model, {nullptr, &just_enough}));
  CHECK_THROWS_AS(Evaluator(model, {nullptr, &too_little}), Error);
  CHECK(too_little.used() == 0);
  PackedLayer& last = model.regions[0].layers.back();
  std::fill(last.scales.begin(), last.scales.end(), 3e38f);
  std::fill(model.regions[0].layers[0].bias.begin(), model.regions[0].layers[0].bias.end(), 1.0f);
  CHECK_THROWS_WITH_AS(Evaluator{model}, "region \"face\" overflows in the rest pose", Error);
}

#if defined(__SSE2__)
TEST_CASE("the host's floating-point mode changes no bit and is restored") {
  const PackedModel model = wide_model();
  const Evaluator evaluator(model);
  Random random(6);
  const std::vector<float> pose = random_pose(model.schema, random), expected = evaluate(evaluator, pose);
  const unsigned saved = _mm_getcsr();
  const unsigned odd = 0x1f80 | 0x8040 | 0x6000;  // flush to zero, denormals are zero, round towards zero
  _mm_setcsr(odd);
  const std::vector<float> positions = evaluate(evaluator, pose);
  const unsigned after = _mm_getcsr();
  _mm_setcsr(saved);
  CHECK((after & ~0x3fu) == odd);
  CHECK(same_bits(positions, expected));
}
#endif

}  // namespace test_evaluator
