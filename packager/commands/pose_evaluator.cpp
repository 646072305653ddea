#include "commands/pose_evaluator.h"

namespace fb::tool {

PoseEvaluator::PoseEvaluator(const facebaker::Model& model, const Parallel& parallel, float lod, bool unskinned)
    : model_(model),
      character_(model_, lod),
      parallel_(parallel),
      lod_(lod),
      unskinned_(unskinned),
      workers_(static_cast<std::uint32_t>(worker_count(parallel))),
      scratch_(model_, workers_) {}

fb_batch_desc PoseEvaluator::batch_of(std::span<const float> controls) const {
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = frames(controls);
  batch.controls = controls.data();
  batch.control_floats = controls.size();
  batch.threads = workers_;
  batch.lod = lod_;
  batch.unskinned = unskinned_ ? 1 : 0;
  return batch;
}

std::vector<float> PoseEvaluator::positions(std::span<const float> controls) {
  fb_batch_desc batch = batch_of(controls);
  std::vector<float> positions(batch.poses * 3 * model_.vertex_count());
  batch.positions = positions.data();
  batch.position_floats = positions.size();
  scratch_.evaluate(batch);
  return positions;
}

std::vector<float> PoseEvaluator::displacements(std::span<const float> controls, std::size_t mesh) {
  fb_batch_desc batch = batch_of(controls);
  const std::size_t size = 3 * std::size_t(model_.vertex_count());
  std::vector<float> positions(batch.poses * size);
  const auto index = static_cast<std::uint32_t>(mesh);
  batch.positions = positions.data();
  batch.position_floats = positions.size();
  batch.meshes = &index;
  batch.mesh_count = 1;
  scratch_.evaluate(batch);
  const std::span<const float> rest = character_.part(mesh, character_.mesh.points);
  std::vector<float> moves;
  moves.reserve(batch.poses * rest.size());
  for (std::size_t f = 0; f < batch.poses; ++f) {
    const auto posed = character_.part(mesh, std::span(positions).subspan(f * size, size));
    for (std::size_t i = 0; i < rest.size(); ++i) moves.push_back(posed[i] - rest[i]);
  }
  return moves;
}

std::vector<float> PoseEvaluator::coefficients(std::span<const float> controls) {
  const std::size_t width = model_.control_count(), count = fb_coefficient_count(model_.get());
  std::vector<float> coefficients(frames(controls) * count);
  for (std::size_t f = 0; f < frames(controls); ++f)
    facebaker::check(
        fb_evaluate_coefficients(model_.get(), scratch_.get(), &controls[f * width], &coefficients[f * count]));
  return coefficients;
}

std::vector<float> PoseEvaluator::sockets(std::span<const float> controls) {
  std::vector<float> sockets(frames(controls) * character_.sockets.size() * FB_FRAME_FLOATS);
  if (sockets.empty()) return sockets;
  fb_batch_desc batch = batch_of(controls);
  batch.sockets = sockets.data();
  batch.socket_floats = sockets.size();
  scratch_.evaluate(batch);
  return sockets;
}

std::vector<float> PoseEvaluator::driven_joints(std::span<const float> controls) {
  std::vector<float> joints(frames(controls) * character_.driven_joints.size() * FB_FRAME_FLOATS);
  if (joints.empty()) return joints;
  fb_batch_desc batch = batch_of(controls);
  batch.joints = joints.data();
  batch.joint_floats = joints.size();
  scratch_.evaluate(batch);
  return joints;
}

}  // namespace fb::tool
