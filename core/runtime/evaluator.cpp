#include "runtime/evaluator.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"
#include "model/activation.h"
#include "model/feature_values.h"
#include "runtime/float_state.h"
#include "runtime/quantized.h"

namespace fb {
namespace {

const PackedModel& checked(const PackedModel& model) {
  check(model);
  return model;
}

// One past the last float that `count` items of `size` floats touch, `stride` apart.
std::size_t extent(std::size_t count, std::size_t stride, std::size_t size) {
  return count == 0 ? 0 : checked_add(checked_multiply(count - 1, stride, "batch"), size, "batch");
}

PanelMatrix digits_of(const PackedLayer& layer, bool high, std::pmr::memory_resource& memory) {
  const auto digit = [&](std::size_t row, std::size_t column) {
    const int weight = layer.weights[row * layer.inputs + column];
    return high ? high_digit(weight) : layer.wide ? low_digit(weight) : weight;
  };
  return PanelMatrix(layer.outputs, layer.inputs, digit, memory);
}

// Every column's values or low digits come first, then the high digits of wide columns.
PanelMatrix digits_of(const PackedRowGroup& group, std::pmr::memory_resource& memory) {
  const auto count = static_cast<std::uint32_t>(group.columns.size());
  std::vector<std::uint32_t> wide;
  for (std::uint32_t c = 0; c < count; ++c)
    if (group.columns[c].wide) wide.push_back(c);
  const auto digit = [&](std::size_t row, std::size_t summand) {
    const std::size_t c = summand < count ? summand : wide[summand - count];
    const int value = group.values[c * group.row_count + row];
    return summand >= count ? high_digit(value) : group.columns[c].wide ? low_digit(value) : value;
  };
  return PanelMatrix(group.row_count, count + wide.size(), digit, memory);
}

void activate(Activation activation, float* values, std::size_t count) {
  switch (activation) {
    case Activation::linear:
      return;
    case Activation::relu:
      for (std::size_t i = 0; i < count; ++i) values[i] = values[i] > 0 ? values[i] : 0;
      return;
    case Activation::tanh:
      for (std::size_t i = 0; i < count; ++i) values[i] = rational_tanh(values[i]);
      return;
    case Activation::silu:
      for (std::size_t i = 0; i < count; ++i) values[i] = rational_silu(values[i]);
      return;
  }
}

}  // namespace

Workspace::Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory)
    : controls_(evaluator.control_count(), &memory),
      features_(evaluator.features_.size(), &memory),
      coefficients_(evaluator.coefficient_count(), &memory),
      layer_input_(evaluator.widest_layer_, &memory),
      layer_output_(evaluator.widest_layer_, &memory),
      summands_(evaluator.longest_list_, &memory),
      rows_(evaluator.rest_.size(), &memory),
      active_(evaluator.longest_list_, &memory) {}

Evaluator::Layer::Layer(const PackedLayer& layer, std::pmr::memory_resource& memory)
    : inputs(layer.inputs),
      outputs(layer.outputs),
      activation(layer.activation),
      skip(layer.skip),
      low(digits_of(layer, false, memory)),
      limit(static_cast<float>(low.limit())),
      scales(layer.scales.begin(), layer.scales.end(), &memory),
      bias(layer.bias.begin(), layer.bias.end(), &memory) {
  if (!layer.wide) return;
  high.emplace(digits_of(layer, true, memory));
  limit = static_cast<float>(std::min(low.limit(), high->limit()));
}

Evaluator::Net::Net(const PackedRegion& region, std::pmr::memory_resource& memory)
    : features(region.features.begin(), region.features.end(), &memory),
      gate(region.gate.features.begin(), region.gate.features.end(), &memory),
      slope(region.gate.slope),
      layers(&memory),
      at_rest(region.layers.back().outputs, &memory) {
  layers.reserve(region.layers.size());
  for (const PackedLayer& layer : region.layers) layers.emplace_back(layer, memory);
}

Evaluator::Chunk::Chunk(const PackedRowGroup& group, std::pmr::memory_resource& memory)
    : first_row(group.first_row), columns(&memory), scales(&memory), digits(digits_of(group, memory)) {
  columns.reserve(digits.columns());
  scales.reserve(digits.columns());
  for (const bool high : {false, true})
    for (const PackedColumn& column : group.columns)
      if (column.wide || !high) {
        columns.push_back(column.column);
        scales.push_back(high ? 256 * column.scale : column.scale);
      }
}

Evaluator::Evaluator(const PackedModel& model, std::pmr::memory_resource& memory, std::uint64_t max_bytes)
    : schema_(checked(model).schema),
      memory_(memory, max_bytes),
      ranges_(&memory_),
      rest_controls_(&memory_),
      rest_(model.rest.points.begin(), model.rest.points.end(), &memory_),
      features_(model.features.begin(), model.features.end(), &memory_),
      direct_(model.direct.begin(), model.direct.end(), &memory_),
      nets_(&memory_),
      chunks_(&memory_),
      order_(model.order.begin(), model.order.end(), &memory_),
      rest_rows_(&memory_),
      coefficient_count_(model.columns) {
  ranges_.reserve(model.schema.control_count());
  rest_controls_.reserve(model.schema.control_count());
  for (const Control& control : model.schema.controls) {
    ranges_.push_back({control.minimum, control.maximum});
    rest_controls_.push_back(control.rest);
  }
  nets_.reserve(model.regions.size());
  for (const PackedRegion& region : model.regions) {
    for (const Layer& layer : nets_.emplace_back(region, memory_).layers) {
      widest_layer_ = std::max<std::size_t>({widest_layer_, layer.inputs, layer.outputs});
      longest_list_ = std::max<std::size_t>(longest_list_, layer.inputs);
    }
  }
  chunks_.reserve(model.groups.size());
  for (const PackedRowGroup& group : model.groups)
    longest_list_ = std::max(longest_list_, chunks_.emplace_back(group, memory_).columns.size());
  rest_rows_.reserve(3 * order_.size());
  for (const std::uint32_t vertex : order_)
    rest_rows_.insert(rest_rows_.end(), rest_.begin() + 3 * vertex, rest_.begin() + 3 * vertex + 3);

  // At rest every feature is 0; what the networks make of that, in this very arithmetic, is what evaluations subtract.
  const FloatState state;
  Workspace workspace(*this);
  for (std::size_t n = 0; n < nets_.size(); ++n) {
    run_layers(nets_[n], workspace);  // its input is still all 0
    std::copy_n(workspace.layer_input_.begin(), nets_[n].at_rest.size(), nets_[n].at_rest.begin());
    std::fill(workspace.layer_input_.begin(), workspace.layer_input_.end(), 0.0f);
    if (!std::all_of(nets_[n].at_rest.begin(), nets_[n].at_rest.end(), [](float v) { return std::isfinite(v); }))
      fail(Status::not_finite, "region \"%s\" overflows in the rest pose", model.regions[n].name.c_str());
  }
}

std::size_t Evaluator::find_nan(const float* controls) const {
  return std::find_if(controls, controls + control_count(), [](float v) { return v != v; }) - controls;
}

void Evaluator::refuse_nan(const float* controls) const {
  const std::size_t control = find_nan(controls);
  if (control < control_count())
    fail(Status::not_finite, "control \"%s\" is not a number", schema_.controls[control].name.c_str());
}

[[gnu::noinline]] void Evaluator::clamp(const float* controls, Workspace& workspace) const {
  std::uint64_t clamped = 0;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const float value = controls[i];
    const float within = value < ranges_[i].minimum   ? ranges_[i].minimum
                         : value > ranges_[i].maximum ? ranges_[i].maximum
                                                      : value;
    clamped += within != value;
    workspace.controls_[i] = within;
  }
  workspace.clamped_ += clamped;
}

void Evaluator::run_layer(const Layer& layer, Workspace& workspace) {
  const float* input = workspace.layer_input_.data();
  float* output = workspace.layer_output_.data();
  const Quantized x = quantize(input, layer.inputs, layer.limit, workspace.active_);
  const float *scales = layer.scales.data(), *bias = layer.bias.data();
  layer.low.multiply(x.active, [&](std::size_t first, std::size_t rows, const std::int32_t* low) {
    float sums[PanelMatrix::panel_rows];
    for (std::size_t r = 0; r < rows; ++r) sums[r] = static_cast<float>(low[r]);
    if (layer.high) {
      std::int32_t high[PanelMatrix::panel_rows];
      layer.high->sum(static_cast<std::uint32_t>(first), x.active, high);
      for (std::size_t r = 0; r < rows; ++r) sums[r] = 256 * static_cast<float>(high[r]) + sums[r];
    }
    for (std::size_t r = 0; r < rows; ++r) output[first + r] = (scales[first + r] * x.step) * sums[r] + bias[first + r];
  });
  activate(layer.activation, output, layer.outputs);
  if (layer.skip)
    for (std::size_t o = 0; o < layer.outputs; ++o) output[o] += input[o];
}

[[gnu::noinline]] void Evaluator::run_layers(const Net& net, Workspace& workspace) {
  for (const Layer& layer : net.layers) {
    run_layer(layer, workspace);
    workspace.layer_input_.swap(workspace.layer_output_);
  }
}

void Evaluator::run_net(const Net& net, Workspace& workspace, float* coefficients) {
  const float* features = workspace.features_.data();
  float opening = 1;
  if (!net.gate.empty()) {
    float sum = 0, most = 0;
    for (const std::uint32_t f : net.gate) {
      const float size = std::fabs(features[f]);
      sum += size;
      most = size > most ? size : most;
    }
    const float open = net.slope * (sum - most);
    opening = open > 0 ? (open < 1 ? open : 1) : 0;
  }
  bool resting = true;
  for (std::size_t i = 0; i < net.features.size(); ++i) {
    workspace.layer_input_[i] = features[net.features[i]];
    resting = resting && workspace.layer_input_[i] == 0;
  }
  if (opening == 0 || resting) {
    std::fill_n(coefficients, net.at_rest.size(), 0.0f);
    return;
  }
  run_layers(net, workspace);
  for (std::size_t i = 0; i < net.at_rest.size(); ++i)
    coefficients[i] = (workspace.layer_input_[i] - net.at_rest[i]) * opening;
}

[[gnu::noinline]] void Evaluator::run_coefficients(const float* controls, Workspace& workspace) const {
  clamp(controls, workspace);
  feature_values(features_, workspace.controls_.data(), rest_controls_.data(), workspace.features_.data());
  float* out = workspace.coefficients_.data();
  for (const std::uint32_t feature : direct_) *out++ = workspace.features_[feature];
  for (const Net& net : nets_) {
    run_net(net, workspace, out);
    out += net.at_rest.size();
  }
}

void Evaluator::run_chunk(const Chunk& chunk, Workspace& workspace, const float* rest, float* positions) {
  const std::size_t count = chunk.columns.size();
  float* summands = workspace.summands_.data();
  const float* coefficients = workspace.coefficients_.data();
  for (std::size_t s = 0; s < count; ++s) summands[s] = coefficients[chunk.columns[s]] * chunk.scales[s];
  const Quantized x = quantize(summands, count, static_cast<float>(chunk.digits.limit()), workspace.active_);
  if (x.step == 0) {
    std::copy_n(rest, chunk.digits.rows(), positions);
    return;
  }
  chunk.digits.multiply(x.active, [&](std::size_t first, std::size_t rows, const std::int32_t* sums) {
    for (std::size_t r = 0; r < rows; ++r)
      positions[first + r] = rest[first + r] + x.step * static_cast<float>(sums[r]);
  });
}

[[gnu::noinline]] void Evaluator::run_pose(const float* controls, float* positions, std::size_t vertex_stride,
                                           Workspace& workspace) const {
  run_coefficients(controls, workspace);
  const bool in_place = order_.empty() && vertex_stride == 3;
  const float* rest = order_.empty() ? rest_.data() : rest_rows_.data();
  float* rows = in_place ? positions : workspace.rows_.data();
  for (const Chunk& chunk : chunks_) run_chunk(chunk, workspace, rest + chunk.first_row, rows + chunk.first_row);
  if (in_place) return;
  for (std::size_t i = 0; i < vertex_count(); ++i)
    std::copy_n(rows + 3 * i, 3, positions + (order_.empty() ? i : order_[i]) * vertex_stride);
}

void Evaluator::evaluate(const float* controls, float* positions, Workspace& workspace,
                         std::size_t vertex_stride) const {
  refuse_nan(controls);
  const FloatState state;
  workspace.clamped_ = 0;
  run_pose(controls, positions, vertex_stride, workspace);
}

void Evaluator::coefficients(const float* controls, float* coefficients, Workspace& workspace) const {
  refuse_nan(controls);
  const FloatState state;
  workspace.clamped_ = 0;
  run_coefficients(controls, workspace);
  std::copy(workspace.coefficients_.begin(), workspace.coefficients_.end(), coefficients);
}

void Evaluator::evaluate_batch(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel) const {
  if (workspaces.empty()) fail(Status::invalid_argument, "a batch needs a workspace");
  const std::size_t control_stride = batch.control_stride ? batch.control_stride : control_count();
  const std::size_t vertex_stride = batch.vertex_stride ? batch.vertex_stride : 3;
  const std::size_t pose_stride =
      batch.pose_stride ? batch.pose_stride : checked_multiply(vertex_stride, vertex_count(), "pose stride");
  if (vertex_stride < 3) fail(Status::invalid_argument, "a vertex stride of %zu floats is below 3", vertex_stride);
  const std::size_t controls_needed = extent(batch.poses, control_stride, control_count());
  if (batch.controls.size() < controls_needed)
    fail(Status::invalid_argument, "%zu poses need %zu control floats; the buffer has %zu", batch.poses,
         controls_needed, batch.controls.size());
  const std::size_t pose_extent = extent(vertex_count(), vertex_stride, 3);
  const std::size_t positions_needed = extent(batch.poses, pose_stride, pose_extent);
  if (batch.positions.size() < positions_needed)
    fail(Status::invalid_argument, "%zu poses need %zu position floats; the buffer has %zu", batch.poses,
         positions_needed, batch.positions.size());
  // Poses one after the other, or interleaved within each vertex.
  const bool interleaved = pose_stride >= 3 && vertex_stride >= extent(batch.poses, pose_stride, 3);
  if (batch.poses > 1 && pose_stride < pose_extent && !interleaved)
    fail(Status::invalid_argument, "poses overlap: %zu floats apart, %zu long", pose_stride, pose_extent);
  for (std::size_t pose = 0; pose < batch.poses; ++pose) {
    const std::size_t control = find_nan(batch.controls.data() + pose * control_stride);
    if (control < control_count())
      fail(Status::not_finite, "pose %zu: control \"%s\" is not a number", pose,
           schema_.controls[control].name.c_str());
  }

  Parallel within = parallel;
  within.threads = static_cast<int>(std::min(worker_count(parallel), workspaces.size()));
  for (Workspace& workspace : workspaces) workspace.clamped_ = workspace.poses_ = 0;
  parallel_for(within, batch.poses, [&](std::size_t pose, std::size_t worker) {
    if (pose >= batch.poses || worker >= workspaces.size())
      fail(Status::invalid_argument, "the host's parallel_for gave pose %zu of %zu to worker %zu of %zu", pose,
           batch.poses, worker, workspaces.size());
    const FloatState state;
    Workspace& workspace = workspaces[worker];
    run_pose(batch.controls.data() + pose * control_stride, batch.positions.data() + pose * pose_stride, vertex_stride,
             workspace);
    ++workspace.poses_;
  });
  std::size_t done = 0;
  for (const Workspace& workspace : workspaces) done += workspace.poses_;
  if (done != batch.poses)
    fail(Status::invalid_argument, "the host's parallel_for ran %zu poses of %zu", done, batch.poses);
}

}  // namespace fb
