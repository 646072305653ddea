#include "commands/pose_animation.h"

#include <algorithm>

namespace fb::tool {
namespace {

std::vector<float> column_displacements(const PackedModel& model, std::uint32_t column) {
  std::vector<float> moved(model.rest.points.size());
  for (const PackedRowBlock& group : model.row_blocks) {
    const auto found = std::lower_bound(group.columns.begin(), group.columns.end(), column,
                                        [](const PackedColumn& c, std::uint32_t wanted) { return c.column < wanted; });
    if (found == group.columns.end() || found->column != column) continue;
    const std::vector<float> values = displacements(group, static_cast<std::size_t>(found - group.columns.begin()));
    for (std::uint32_t r = 0; r < group.row_count; ++r) moved[model.coordinate(group.first_row + r)] = values[r];
  }
  return moved;
}

MorphAnimation from_frames(const Evaluator& evaluator, std::span<const float> controls, const Parallel& parallel) {
  const std::size_t frames = controls.size() / evaluator.control_count(), size = 3 * evaluator.vertex_count();
  const std::vector<float> positions = evaluate_frames(evaluator, controls, parallel);
  const auto rest = evaluator.rest_positions();
  MorphAnimation animation;
  animation.weights.assign(frames * frames, 0);
  for (std::size_t f = 0; f < frames; ++f) {
    auto& target = animation.targets.emplace_back(size);
    for (std::size_t i = 0; i < size; ++i) target[i] = positions[f * size + i] - rest[i];
    animation.weights[f * frames + f] = 1;
  }
  return animation;
}

MorphAnimation from_basis(const PackedModel& model, const Evaluator& evaluator, std::span<const float> controls) {
  const std::size_t frames = controls.size() / evaluator.control_count(), count = evaluator.coefficient_count();
  std::vector<float> coefficients(frames * count);
  Workspace workspace(evaluator);
  for (std::size_t f = 0; f < frames; ++f)
    evaluator.coefficients(&controls[f * evaluator.control_count()], &coefficients[f * count], workspace);
  std::vector<std::size_t> used;  // a column that rests throughout the clip is left out
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t f = 0; f < frames; ++f)
      if (coefficients[f * count + c] != 0) {
        used.push_back(c);
        break;
      }
  if (used.empty()) used.push_back(0);
  MorphAnimation animation;
  for (const std::size_t c : used)
    animation.targets.push_back(column_displacements(model, static_cast<std::uint32_t>(c)));
  for (std::size_t f = 0; f < frames; ++f)
    for (const std::size_t c : used) animation.weights.push_back(coefficients[f * count + c]);
  return animation;
}

}  // namespace

std::vector<float> evaluate_frames(const Evaluator& evaluator, std::span<const float> controls,
                                   const Parallel& parallel) {
  Batch batch;
  batch.poses = controls.size() / evaluator.control_count();
  batch.controls = controls;
  std::vector<float> positions(batch.poses * 3 * evaluator.vertex_count());
  batch.positions = {positions.data(), positions.size()};
  std::vector<Workspace> workspaces;
  for (std::size_t w = 0; w < worker_count(parallel); ++w) workspaces.emplace_back(evaluator);
  evaluator.evaluate_batch(batch, workspaces, parallel);
  return positions;
}

MorphAnimation animate(const PackedModel& model, const Evaluator& evaluator, std::span<const float> controls,
                       double fps, const Parallel& parallel) {
  const std::size_t frames = controls.size() / evaluator.control_count();
  MorphAnimation animation = frames <= evaluator.coefficient_count() ? from_frames(evaluator, controls, parallel)
                                                                     : from_basis(model, evaluator, controls);
  animation.fps = fps;
  return animation;
}

}  // namespace fb::tool
