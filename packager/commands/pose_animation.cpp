#include "commands/pose_animation.h"

#include <map>

namespace fb::tool {
namespace {

MorphAnimation from_frames(PoseEvaluator& evaluator, std::span<const float> controls) {
  const std::size_t frames = controls.size() / evaluator.model().control_count();
  const std::size_t size = 3 * std::size_t(evaluator.model().vertex_count());
  const std::vector<float> positions = evaluator.positions(controls);
  const float* rest = evaluator.model().rest_positions();
  MorphAnimation animation;
  animation.weights.assign(frames * frames, 0);
  for (std::size_t f = 0; f < frames; ++f) {
    auto& target = animation.targets.emplace_back(size);
    for (std::size_t i = 0; i < size; ++i) target[i] = positions[f * size + i] - rest[i];
    animation.weights[f * frames + f] = 1;
  }
  return animation;
}

// Displacements of the vertices for one unit of each of these coefficients.
std::vector<std::vector<float>> column_displacements(const facebaker::Model& model,
                                                     const std::vector<std::uint32_t>& wanted) {
  std::map<std::uint32_t, std::size_t> target_of;
  for (std::size_t t = 0; t < wanted.size(); ++t) target_of[wanted[t]] = t;
  std::vector<std::vector<float>> targets(wanted.size(), std::vector<float>(3 * std::size_t(model.vertex_count())));
  const std::uint32_t* order = fb_vertex_order(model.get());
  for (std::uint32_t b = 0; b < fb_row_block_count(model.get()); ++b) {
    fb_row_block block;
    fb_row_block_init(&block);
    facebaker::check(fb_row_block_at(model.get(), b, &block));
    if (block.column_count == 0) continue;
    std::vector<std::uint32_t> columns(block.column_count);
    std::vector<float> values(std::size_t(block.column_count) * block.row_count);
    facebaker::check(fb_row_block_values(model.get(), b, columns.data(), values.data()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto target = target_of.find(columns[c]);
      if (target == target_of.end()) continue;
      for (std::size_t r = 0; r < block.row_count; ++r) {
        const std::size_t row = block.first_row + r;
        targets[target->second][order ? 3 * std::size_t(order[row / 3]) + row % 3 : row] =
            values[c * block.row_count + r];
      }
    }
  }
  return targets;
}

MorphAnimation from_basis(PoseEvaluator& evaluator, std::span<const float> controls) {
  const std::size_t frames = controls.size() / evaluator.model().control_count();
  const std::uint32_t count = fb_coefficient_count(evaluator.model().get());
  const std::vector<float> coefficients = evaluator.coefficients(controls);
  std::vector<std::uint32_t> used;  // coefficients that are not 0 in every frame
  for (std::uint32_t c = 0; c < count; ++c)
    for (std::size_t f = 0; f < frames; ++f)
      if (coefficients[f * count + c] != 0) {
        used.push_back(c);
        break;
      }
  if (used.empty()) used.push_back(0);
  MorphAnimation animation;
  animation.targets = column_displacements(evaluator.model(), used);
  for (std::size_t f = 0; f < frames; ++f)
    for (const std::uint32_t c : used) animation.weights.push_back(coefficients[f * count + c]);
  return animation;
}

}  // namespace

PoseEvaluator::PoseEvaluator(const facebaker::Model& model, const Parallel& parallel)
    : model_(model), workers_(static_cast<std::uint32_t>(worker_count(parallel))), scratch_(model_, workers_) {}

std::vector<float> PoseEvaluator::positions(std::span<const float> controls) {
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = controls.size() / model_.control_count();
  batch.controls = controls.data();
  batch.control_floats = controls.size();
  std::vector<float> positions(batch.poses * 3 * model_.vertex_count());
  batch.positions = positions.data();
  batch.position_floats = positions.size();
  batch.threads = workers_;
  scratch_.evaluate(batch);
  return positions;
}

std::vector<float> PoseEvaluator::coefficients(std::span<const float> controls) {
  const std::size_t width = model_.control_count(), frames = controls.size() / width;
  const std::size_t count = fb_coefficient_count(model_.get());
  std::vector<float> coefficients(frames * count);
  for (std::size_t f = 0; f < frames; ++f)
    facebaker::check(
        fb_evaluate_coefficients(model_.get(), scratch_.get(), &controls[f * width], &coefficients[f * count]));
  return coefficients;
}

MorphAnimation animate(PoseEvaluator& evaluator, std::span<const float> controls, double fps) {
  const std::size_t frames = controls.size() / evaluator.model().control_count();
  MorphAnimation animation = frames <= fb_coefficient_count(evaluator.model().get()) ? from_frames(evaluator, controls)
                                                                                     : from_basis(evaluator, controls);
  animation.fps = fps;
  return animation;
}

}  // namespace fb::tool
