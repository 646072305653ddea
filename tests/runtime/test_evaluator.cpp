#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "base/status.h"
#include "runtime/evaluator.h"
#include "test_models.h"

using namespace fb;

namespace {

// A face of ordinary size and shape: deep skip layers, global and local columns, odd widths.
FaceModel wide_model() {
  FaceModel model = tiny_model();
  Random random(7);
  model.schema.controls.clear();
  model.network.features.clear();
  Region region{"whole", {}, {}};
  for (std::uint32_t c = 0; c < 90; ++c) {
    model.schema.controls.push_back({"control" + std::to_string(c), -1, 1, c % 3 == 0 ? 0.5f : 0.0f, ""});
    model.network.features.push_back({Feature::Kind::identity, c, 0.5f, 0});
    model.network.features.push_back({Feature::Kind::ramp, c, c % 2 ? 1.0f : -1.0f, 0.25f});
    region.features.insert(region.features.end(), {2 * c, 2 * c + 1});
  }
  const auto layer = [&](std::uint32_t inputs, std::uint32_t outputs, Activation activation, bool skip) {
    DenseLayer dense = random_layer(random, inputs, outputs, activation, skip);
    for (float& weight : dense.weights) weight /= std::sqrt(float(inputs));
    return dense;
  };
  region.layers = {layer(180, 130, Activation::relu, false), layer(130, 130, Activation::relu, true),
                   layer(130, 130, Activation::relu, true), layer(130, 37, Activation::linear, false)};
  model.network.direct = {5, 8, 5};
  model.network.regions = {region};
  model.rest = grid_mesh(23, 17);
  model.rest.points[4] = -0.0f;
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  std::vector<float> dense = random_values(random, std::size_t(40) * rows, 2.0f);
  for (std::uint32_t column = 0; column < 40; ++column)
    for (std::uint32_t row = 0; row < rows; ++row)
      if (column % 4 && (row / 128) % 4 != column % 4) dense[std::size_t(column) * rows + row] = 0;
  model.basis = make_basis(rows, 40, dense);
  return model;
}

// What FORMAT.md defines, in double and in the plainest way.
std::vector<double> reference(const FaceModel& model, const std::vector<float>& controls) {
  std::vector<double> features;
  for (const Feature& f : model.network.features) {
    const Control& c = model.schema.controls[f.control];
    const double u = (std::clamp<double>(controls[f.control], c.minimum, c.maximum) - c.rest) * f.scale;
    features.push_back(f.kind == Feature::Kind::identity ? u : std::max(u - f.threshold, 0.0));
  }
  const auto run = [](const Region& region, const std::vector<double>& all) {
    std::vector<double> x;
    for (const std::uint32_t f : region.features) x.push_back(all[f]);
    for (const DenseLayer& layer : region.layers) {
      std::vector<double> y(layer.outputs);
      for (std::uint32_t o = 0; o < layer.outputs; ++o) {
        y[o] = layer.bias[o];
        for (std::uint32_t i = 0; i < layer.inputs; ++i) y[o] += double(layer.weights[o * layer.inputs + i]) * x[i];
        if (layer.activation == Activation::relu) y[o] = std::max(y[o], 0.0);
        if (layer.skip) y[o] += x[o];
      }
      x = y;
    }
    return x;
  };
  std::vector<double> coefficients;
  for (const std::uint32_t f : model.network.direct) coefficients.push_back(features[f]);
  for (const Region& region : model.network.regions) {
    const auto posed = run(region, features), rest = run(region, std::vector<double>(features.size()));
    for (std::size_t i = 0; i < posed.size(); ++i) coefficients.push_back(posed[i] - rest[i]);
  }
  std::vector<double> positions(model.rest.points.begin(), model.rest.points.end());
  for (const RowGroup& group : model.basis.groups)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::uint32_t r = 0; r < group.row_count; ++r)
        positions[group.first_row + r] += group.values[c * group.row_count + r] * coefficients[group.columns[c]];
  return positions;
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

TEST_CASE("poses agree with the definition in double precision") {
  for (const FaceModel& model : {tiny_model(), tiny_model(2), wide_model()}) {
    const Evaluator evaluator(model);
    Random random(3);
    double worst = 0, moved = 0;
    for (int n = 0; n < 50; ++n) {
      const std::vector<float> pose = random_pose(model.schema, random), positions = evaluate(evaluator, pose);
      const std::vector<double> expected = reference(model, pose);
      for (std::size_t i = 0; i < positions.size(); ++i) {
        worst = std::max(worst, std::abs(positions[i] - expected[i]));
        moved = std::max(moved, std::abs(expected[i] - model.rest.points[i]));
      }
    }
    CHECK(moved > 0.02 * model.rest.diagonal());
    CHECK(worst < 1e-6 * model.rest.diagonal());
  }
}

TEST_CASE("controls at rest give the rest mesh to the last bit and no coefficients") {
  for (const FaceModel& model : {tiny_model(), wide_model()}) {
    const Evaluator evaluator(model);
    CHECK(same_bits(evaluate(evaluator, model.schema.rest_pose()), model.rest.points));
    Workspace workspace(evaluator);
    std::vector<float> coefficients(evaluator.coefficient_count(), 1.0f);
    evaluator.coefficients(model.schema.rest_pose().data(), coefficients.data(), workspace);
    CHECK(std::all_of(coefficients.begin(), coefficients.end(), [](float c) { return c == 0; }));
  }
}

TEST_CASE("coefficients are the weights of the basis' columns") {
  const FaceModel model = wide_model();
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  Random random(4);
  const std::vector<float> pose = random_pose(model.schema, random), positions = evaluate(evaluator, pose);
  std::vector<float> weights(evaluator.coefficient_count());
  evaluator.coefficients(pose.data(), weights.data(), workspace);
  std::vector<double> sum(model.rest.points.begin(), model.rest.points.end());
  for (const RowGroup& group : model.basis.groups)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::uint32_t r = 0; r < group.row_count; ++r)
        sum[group.first_row + r] += double(weights[group.columns[c]]) * group.values[c * group.row_count + r];
  for (std::size_t i = 0; i < sum.size(); ++i) CHECK(positions[i] == doctest::Approx(sum[i]).epsilon(1e-5));
}

TEST_CASE("values outside their range are clamped and counted; NaN is refused by name") {
  const FaceModel model = tiny_model();
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

TEST_CASE("a batch gives the bits of single poses, whatever the strides, the layout and the threads") {
  const FaceModel model = wide_model();
  const Evaluator evaluator(model);
  const std::size_t poses = 13, controls = evaluator.control_count(), vertices = evaluator.vertex_count();
  Random random(5);
  const std::size_t control_stride = controls + 3;
  std::vector<float> input(poses * control_stride, NAN);  // what lies between poses is not read
  std::vector<std::vector<float>> single;
  for (std::size_t p = 0; p < poses; ++p) {
    const std::vector<float> pose = random_pose(model.schema, random);
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
      evaluator.evaluate_batch({poses, input, control_stride, output, layout.pose_stride, layout.vertex_stride},
                               workspaces, {threads});
      CHECK(same_bits(output, expected));
    }
}

TEST_CASE("a batch that does not fit is refused before anything is written") {
  const FaceModel model = tiny_model();
  const Evaluator evaluator(model);
  std::vector<Workspace> workspaces;
  workspaces.emplace_back(evaluator);
  std::vector<float> input(2 * 5, 0.0f), output(2 * 90, 7.0f);
  const std::vector<float> before = output;
  const auto refuses = [&](const Batch& batch) {
    CHECK_THROWS_AS(evaluator.evaluate_batch(batch, workspaces), Error);
    CHECK(same_bits(output, before));
  };
  refuses({2, std::span(input).first(9), 0, output});
  refuses({2, input, 0, std::span(output).first(179)});
  refuses({2, input, 0, output, 0, 2});
  refuses({2, input, 0, output, 89, 3});
  refuses({2, input, SIZE_MAX / 2, output});
  refuses({SIZE_MAX, input, 0, output});
  input[7] = NAN;
  refuses({2, input, 0, output});
}

TEST_CASE("a host's scheduler that breaks its promise is found out") {
  const FaceModel model = tiny_model();
  const Evaluator evaluator(model);
  std::vector<Workspace> workspaces;
  for (int w = 0; w < 2; ++w) workspaces.emplace_back(evaluator);
  std::vector<float> input(3 * 5, 0.0f), output(3 * 90);
  const auto run = [&](HostParallelFor host) {
    evaluator.evaluate_batch({3, input, 0, output}, workspaces, {2, host, nullptr});
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
  FaceModel model = tiny_model();
  const std::uint64_t bytes = Evaluator(model).bytes();
  CHECK(bytes > model.rest.points.size() * sizeof(float));
  CHECK_NOTHROW(Evaluator(model, *std::pmr::get_default_resource(), bytes));
  CHECK_THROWS_AS(Evaluator(model, *std::pmr::get_default_resource(), bytes - 1), Error);
  for (DenseLayer& layer : model.network.regions[0].layers)
    std::fill(layer.weights.begin(), layer.weights.end(), 3e38f);
  std::fill_n(model.network.regions[0].layers[0].bias.begin(), 8, 3e38f);
  CHECK_THROWS_AS(Evaluator{model}, Error);
}

#if defined(__SSE2__)
TEST_CASE("the host's floating-point mode changes no bit and is given back") {
  const FaceModel model = wide_model();
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
