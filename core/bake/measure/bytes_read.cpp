#include "bake/measure/bytes_read.h"

#include <algorithm>
#include <numeric>

#include "bake/measure/pose_activity.h"

namespace fb::bake {
namespace {

constexpr std::uint64_t control_bytes = 12, feature_bytes = 20, index_bytes = 4, position_bytes = 12, scaled_bytes = 8;

std::uint64_t number_bytes(bool wide) {
  return wide ? 2 : 1;
}

// Of one input of a first layer.
std::uint64_t input_bytes(const PackedRegion& region) {
  return region.layers.front().outputs * number_bytes(region.layers.front().wide);
}

}  // namespace

BytesReadCounter::BytesReadCounter(const PackedModel& model) : model_(&model), direct_(model.direct.size(), 0) {
  always_ = model.schema.controls.size() * control_bytes + model.features.size() * feature_bytes +
            model.direct.size() * index_bytes + model.rest.vertex_count() * position_bytes +
            model.order.size() * index_bytes;
  std::vector<std::uint64_t*> owner;  // of a column's bytes
  for (std::uint64_t& bytes : direct_) owner.push_back(&bytes);
  regions_.reserve(model.regions.size());
  for (const PackedRegion& region : model.regions) {
    always_ += (region.features.size() + region.gate.features.size()) * index_bytes;
    std::uint64_t& bytes = regions_.emplace_back(0);
    for (const PackedLayer& layer : region.layers) {
      if (&layer != &region.layers.front()) bytes += layer.weights.size() * number_bytes(layer.wide);
      bytes += layer.outputs * scaled_bytes;
    }
    owner.insert(owner.end(), region.layers.back().outputs, &bytes);
  }
  for (const PackedRowBlock& group : model.row_blocks)
    for (const PackedColumn& column : group.columns)
      *owner.at(column.column) += group.row_count * number_bytes(column.wide) + scaled_bytes;
}

std::uint64_t BytesReadCounter::of_pose(std::span<const float> controls) const {
  const PoseActivity pose = pose_activity(*model_, controls);
  std::uint64_t bytes = always_;
  for (std::size_t d = 0; d < direct_.size(); ++d)
    if (pose.features[model_->direct[d]] != 0) bytes += direct_[d];
  for (std::size_t r = 0; r < regions_.size(); ++r)
    if (const std::uint32_t active = pose.region_inputs[r]; active > 0)
      bytes += regions_[r] + active * input_bytes(model_->regions[r]);
  return bytes;
}

std::uint64_t BytesReadCounter::total() const {
  std::uint64_t bytes = always_;
  for (const std::uint64_t direct : direct_) bytes += direct;
  for (std::size_t r = 0; r < regions_.size(); ++r)
    bytes += regions_[r] + model_->regions[r].features.size() * input_bytes(model_->regions[r]);
  return bytes;
}

BytesRead bytes_read_per_pose(const PackedModel& model, const PoseSet& poses) {
  constexpr std::size_t most_poses = 500;
  const BytesReadCounter counter(model);
  const PoseSet some = poses.subsampled(most_poses);
  BytesRead result;
  result.runtime_bytes = counter.total();
  result.poses = some.size();
  if (some.size() == 0) return result;
  const std::vector<float> controls = some.controls();
  const std::size_t width = model.schema.controls.size();
  std::vector<std::uint64_t> bytes;
  for (std::size_t pose = 0; pose < some.size(); ++pose) {
    bytes.push_back(counter.of_pose(std::span(controls).subspan(pose * width, width)));
  }
  std::sort(bytes.begin(), bytes.end());
  result.mean = double(std::accumulate(bytes.begin(), bytes.end(), std::uint64_t(0))) / double(bytes.size());
  result.p95 = bytes[(bytes.size() * 95 + 99) / 100 - 1];
  result.max = bytes.back();
  return result;
}

}  // namespace fb::bake
