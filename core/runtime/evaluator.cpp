#include "runtime/evaluator.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"
#include "runtime/float_state.h"

namespace fb {
namespace {

const FaceModel& checked(const FaceModel& model) {
  check(model);
  return model;
}

// One past the last float that `count` items of `size` floats touch, `stride` apart.
std::size_t extent(std::size_t count, std::size_t stride, std::size_t size) {
  return count == 0 ? 0 : checked_add(checked_multiply(count - 1, stride, "batch"), size, "batch");
}

}  // namespace

Workspace::Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory)
    : controls_(evaluator.control_count(), &memory),
      features_(evaluator.features_.size(), &memory),
      coefficients_(evaluator.coefficient_count(), &memory),
      layer_input_(evaluator.widest_layer_, &memory),
      layer_output_(evaluator.widest_layer_, &memory),
      active_(evaluator.longest_list_, &memory) {}

Evaluator::Evaluator(const FaceModel& model, std::pmr::memory_resource& memory, std::uint64_t max_bytes)
    : schema_(checked(model).schema),
      memory_(memory, max_bytes),
      ranges_(&memory_),
      rest_(model.rest.points.begin(), model.rest.points.end(), &memory_),
      features_(model.network.features.begin(), model.network.features.end(), &memory_),
      direct_(model.network.direct.begin(), model.network.direct.end(), &memory_),
      nets_(&memory_),
      basis_(model.basis, memory_),
      coefficient_count_(model.network.coefficient_count()),
      longest_list_(basis_.longest_list()) {
  ranges_.reserve(model.schema.control_count());
  for (const Control& control : model.schema.controls)
    ranges_.push_back({control.minimum, control.maximum, control.rest});
  nets_.reserve(model.network.regions.size());
  for (const Region& region : model.network.regions) {
    Net& net = nets_.emplace_back(Net{{region.features.begin(), region.features.end(), &memory_},
                                      std::pmr::vector<Layer>(&memory_),
                                      std::pmr::vector<float>(region.layers.back().outputs, &memory_)});
    net.layers.reserve(region.layers.size());
    for (const DenseLayer& layer : region.layers) {
      net.layers.push_back({PanelMatrix(layer, memory_),
                            {layer.bias.begin(), layer.bias.end(), &memory_},
                            layer.activation == Activation::relu,
                            layer.skip});
      widest_layer_ = std::max<std::size_t>({widest_layer_, layer.inputs, layer.outputs});
      longest_list_ = std::max<std::size_t>(longest_list_, layer.inputs);
    }
  }

  // At rest every feature is 0; what the networks make of that, in this very arithmetic, is what evaluations subtract.
  const FloatState state;
  Workspace workspace(*this);
  for (std::size_t n = 0; n < nets_.size(); ++n) {
    run_net(nets_[n], workspace);
    std::copy_n(workspace.layer_input_.begin(), nets_[n].at_rest.size(), nets_[n].at_rest.begin());
    if (!std::all_of(nets_[n].at_rest.begin(), nets_[n].at_rest.end(), [](float v) { return std::isfinite(v); }))
      fail(Status::not_finite, "region \"%s\" overflows in the rest pose", model.network.regions[n].name.c_str());
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

void Evaluator::run_features(Workspace& workspace) const {
  for (std::size_t f = 0; f < features_.size(); ++f) {
    const Feature& feature = features_[f];
    const float u = (workspace.controls_[feature.control] - ranges_[feature.control].rest) * feature.scale;
    const float above = u - feature.threshold;
    workspace.features_[f] = feature.kind == Feature::Kind::identity ? u : above > 0 ? above : 0;
  }
}

[[gnu::noinline]] void Evaluator::run_net(const Net& net, Workspace& workspace) const {
  for (std::size_t i = 0; i < net.features.size(); ++i)
    workspace.layer_input_[i] = workspace.features_[net.features[i]];
  for (const Layer& layer : net.layers) {
    const float* input = workspace.layer_input_.data();
    float* output = workspace.layer_output_.data();
    const float* bias = layer.bias.data();
    layer.weights.multiply(input, workspace.active_, [&](std::size_t first, std::size_t rows, const float* sums) {
      for (std::size_t r = 0; r < rows; ++r) {
        float value = sums[r] + bias[first + r];
        if (layer.relu) value = value > 0 ? value : 0;
        if (layer.skip) value += input[first + r];
        output[first + r] = value;
      }
    });
    workspace.layer_input_.swap(workspace.layer_output_);
  }
}

[[gnu::noinline]] void Evaluator::run_coefficients(const float* controls, Workspace& workspace) const {
  clamp(controls, workspace);
  run_features(workspace);
  float* out = workspace.coefficients_.data();
  for (const std::uint32_t feature : direct_) *out++ = workspace.features_[feature];
  for (const Net& net : nets_) {
    run_net(net, workspace);
    for (std::size_t i = 0; i < net.at_rest.size(); ++i) *out++ = workspace.layer_input_[i] - net.at_rest[i];
  }
}

[[gnu::noinline]] void Evaluator::run_pose(const float* controls, float* positions, std::size_t vertex_stride,
                                           Workspace& workspace) const {
  run_coefficients(controls, workspace);
  const std::size_t gap = vertex_stride - 3;
  basis_.multiply(workspace.coefficients_.data(), workspace.active_,
                  [&](std::size_t first, std::size_t rows, const float* sums) {
                    const float* rest = rest_.data() + first;
                    float* out = positions + first;
                    if (gap == 0)
                      for (std::size_t r = 0; r < rows; ++r) out[r] = rest[r] + sums[r];
                    else
                      for (std::size_t r = 0; r < rows; ++r) out[r + (first + r) / 3 * gap] = rest[r] + sums[r];
                  });
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
