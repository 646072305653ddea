#include "bake/measure/calibrate_machine.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "bake/measure/time_poses.h"
#include "base/random.h"

namespace fb::bake {
namespace {

// Sizes of a made-up face.
struct FaceSizes {
  std::uint32_t vertices, controls, pairs;        // pairs: products of two controls
  std::uint32_t block_rows;                       // of a row block
  std::uint32_t shapes;                           // columns of controls and pairs in a row block, on average
  std::uint32_t regions, layers, width, outputs;  // of networks: hidden layers and their width
  float wide;                                     // share of columns of 16 bits
};

std::uint32_t log_uniform(Random& random, double low, double high) {
  return static_cast<std::uint32_t>(low * std::pow(high / low, double(random.uniform())));
}

FaceSizes random_sizes(Random& random) {
  FaceSizes sizes;
  sizes.vertices = log_uniform(random, 1000, 25'000);
  sizes.controls = log_uniform(random, 20, 500);
  sizes.pairs = log_uniform(random, 1, 200);
  sizes.block_rows = 12 * (1 + random.below(16));
  sizes.shapes = log_uniform(random, 6, 60);
  sizes.regions = random.uniform() < 0.3f ? 0 : log_uniform(random, 1, 16);
  sizes.layers = 1 + random.below(3);
  sizes.width = 32 * log_uniform(random, 1, 8);
  sizes.outputs = log_uniform(random, 4, 64);
  sizes.wide = 0.5f * random.uniform();
  return sizes;
}

PackedLayer made_layer(Random& random, std::uint32_t inputs, std::uint32_t outputs, Activation activation) {
  PackedLayer layer{inputs, outputs, activation, false, false, {}, {}, {}};
  for (std::size_t i = 0; i < std::size_t(inputs) * outputs; ++i)
    layer.weights.push_back(static_cast<std::int16_t>(int(random.below(127)) - 63));
  layer.scales.assign(outputs, 1 / (64 * std::sqrt(float(inputs))));
  layer.bias.assign(outputs, 0.1f);
  return layer;
}

PackedRegion made_region(Random& random, const FaceSizes& sizes, std::uint32_t number) {
  PackedRegion region;
  region.name = "region " + std::to_string(number);
  for (std::uint32_t c = 0; c < sizes.controls; ++c)
    if (c % sizes.regions == number || random.uniform() < 0.2f) region.features.push_back(c);
  auto inputs = static_cast<std::uint32_t>(region.features.size());
  for (std::uint32_t l = 0; l < sizes.layers; ++l, inputs = sizes.width)
    region.layers.push_back(made_layer(random, inputs, sizes.width, Activation::silu));
  region.layers.push_back(made_layer(random, inputs, sizes.outputs, Activation::linear));
  return region;
}

// Some of the direct columns, and those of the region that its rows belong to.
PackedRowBlock made_row_block(Random& random, const FaceSizes& sizes, std::uint32_t first_row) {
  const std::uint32_t rows = 3 * sizes.vertices, direct = sizes.controls + sizes.pairs;
  PackedRowBlock block{first_row, std::min(sizes.block_rows, rows - first_row), {}, {}};
  const auto add = [&](std::uint32_t column) {
    const bool wide = random.uniform() < sizes.wide;
    const int reach = wide ? 4095 : largest_narrow;
    block.columns.push_back({column, wide, 1e-5f});
    for (std::uint32_t r = 0; r < block.row_count; ++r)
      block.values.push_back(static_cast<std::int16_t>(int(random.below(std::uint32_t(2 * reach + 1))) - reach));
  };
  for (std::uint32_t d = 0; d < direct; ++d)
    if (random.uniform() * float(direct) < float(sizes.shapes)) add(d);
  const auto region = static_cast<std::uint32_t>(std::uint64_t(first_row) * sizes.regions / rows);
  for (std::uint32_t o = 0; o < sizes.outputs && sizes.regions > 0; ++o) add(direct + region * sizes.outputs + o);
  return block;
}

PackedModel made_face(Random& random, const FaceSizes& sizes) {
  PackedModel face;
  face.schema.name = "made up";
  for (std::uint32_t c = 0; c < sizes.controls; ++c) {
    face.schema.controls.push_back({"control " + std::to_string(c), 0, 1, 0, ""});
    face.features.push_back({.kind = Feature::Kind::identity, .control = c});
  }
  for (std::uint32_t p = 0; p < sizes.pairs; ++p)
    face.features.push_back({.kind = Feature::Kind::product,
                             .first = random.below(sizes.controls),
                             .second = random.below(sizes.controls)});
  face.direct.resize(face.features.size());
  std::iota(face.direct.begin(), face.direct.end(), 0);
  for (std::uint32_t r = 0; r < sizes.regions; ++r) face.regions.push_back(made_region(random, sizes, r));
  face.columns = static_cast<std::uint32_t>(face.direct.size()) + sizes.regions * sizes.outputs;
  for (std::uint32_t i = 0; i < 3 * sizes.vertices; ++i) face.rest.points.push_back(random.uniform());
  face.rest.polygon_sizes = {3};
  face.rest.polygon_corners = {0, 1, 2};
  // In another order than the source's, though not by much: as in baked faces.
  constexpr std::uint32_t reach = 64;
  face.order.resize(sizes.vertices);
  std::iota(face.order.begin(), face.order.end(), 0);
  for (std::uint32_t v = 1; v < sizes.vertices; ++v)
    std::swap(face.order[v], face.order[v - random.below(std::min(v + 1, reach))]);
  for (std::uint32_t row = 0; row < 3 * sizes.vertices; row += sizes.block_rows)
    face.row_blocks.push_back(made_row_block(random, sizes, row));
  return face;
}

// Poses with the same share of the controls away from rest, as the frames of a shot have.
TimedWork timed_work(const runtime::Evaluator& evaluator, const PoseWorkCounter& counter, Random& random, float share) {
  constexpr std::size_t poses = 12, rounds = 7;
  const std::size_t width = evaluator.control_count();
  std::vector<float> controls(poses * width);
  for (std::size_t c = 0; c < width; ++c) {
    const bool active = random.uniform() < share;
    for (std::size_t pose = 0; pose < poses && active; ++pose) controls[pose * width + c] = random.uniform(0.1f, 1);
  }
  const std::vector<double> times = time_poses(evaluator, controls, rounds);
  TimedWork timed;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    timed.microseconds += times[pose] / poses;
    const PoseWork work = counter.of_pose(std::span(controls).subspan(pose * width, width));
    for (std::size_t i = 0; i < work.size(); ++i) timed.work[i] += work[i] / poses;
  }
  return timed;
}

std::string processor_of_machine() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

// Coordinate descent on the normal equations, which converges as they are positive semidefinite.
PoseWork fit_nanoseconds(std::span<const TimedWork> cases) {
  constexpr std::size_t kinds = pose_work_names.size();
  constexpr int sweeps = 20'000;
  std::array<PoseWork, kinds> products = {};
  PoseWork target = {}, fitted = {};
  for (const TimedWork& timed : cases)
    for (std::size_t i = 0; i < kinds; ++i) {
      const double relative = timed.work[i] / (1e3 * timed.microseconds);
      target[i] += relative;
      for (std::size_t k = 0; k < kinds; ++k) products[i][k] += relative * timed.work[k] / (1e3 * timed.microseconds);
    }
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t i = 0; i < kinds; ++i) {
      if (products[i][i] <= 0) continue;
      const double rest = target[i] - std::inner_product(fitted.begin(), fitted.end(), products[i].begin(), 0.0);
      fitted[i] = std::max(0.0, fitted[i] + rest / products[i][i]);
    }
  return fitted;
}

Calibration calibrate_machine(Progress& progress) {
  constexpr std::uint64_t faces = 16;
  Calibration calibration;
  calibration.machine.name = runtime::choose_kernels().name;
  calibration.machine.processor = processor_of_machine();
  progress.begin("timing made-up faces", faces);
  for (std::uint64_t face = 0; face < faces; ++face) {
    Random random(1, face);
    const PackedModel model = made_face(random, random_sizes(random));
    const runtime::Evaluator evaluator(model);
    const PoseWorkCounter counter(model);
    for (const float share : {0.0f, 0.02f, 0.05f, 0.1f, 0.2f, 0.4f, 0.8f})
      calibration.cases.push_back(timed_work(evaluator, counter, random, share));
    progress.step(face + 1);
  }
  calibration.machine.nanoseconds = fit_nanoseconds(calibration.cases);
  double squares = 0;
  for (const TimedWork& timed : calibration.cases) {
    const double error = calibration.machine.microseconds(timed.work) / timed.microseconds - 1;
    squares += error * error;
    calibration.worst_error = std::max(calibration.worst_error, std::abs(error));
  }
  calibration.rms_error = std::sqrt(squares / double(calibration.cases.size()));
  return calibration;
}

}  // namespace fb::bake
