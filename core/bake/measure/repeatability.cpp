#include "bake/measure/repeatability.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bake/measure/errors.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double tolerance = 1e-5;  // over D

}  // namespace

Repeatability measure_repeatability(const PoseSet& recorded, RigEvaluator& rig, Progress& progress) {
  const PoseSet poses = recorded.subsampled(repeated_poses);
  const std::size_t size = rig.coordinate_count(), width = rig.rest_pose().size();
  const std::vector<float> controls = poses.controls();
  std::vector<float> before(size), now(size);
  ErrorSums sums;
  EvaluationStage stage(progress, Phase::measuring, "evaluating poses again", poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses.read_points(i, 1, before);
    rig.evaluate_apart(std::span(controls).subspan(i * width, width), 1, now);
    sums.add_frame(now, before);
    stage.advance(1);
  }
  const Errors errors = sums.figures(rig.diagonal());
  return {poses.size(), errors.rms, errors.max};
}

std::optional<std::string> repeatability_warning(const Repeatability& repeatability) {
  if (repeatability.max <= tolerance) return std::nullopt;
  // Two answers that differ by d each lie about d / sqrt(2) from their mean, the best that a face can learn.
  return format(
      "the rig does not repeat itself: of %zu poses evaluated again, vertices lie up to %.2g of the diagonal elsewhere "
      "(rms %.2g); no face of it can be measured below an rms error of about %.2g",
      repeatability.poses, repeatability.max, repeatability.rms, repeatability.rms / std::sqrt(2.0));
}

}  // namespace fb::bake
