#include "commands/control_targets.h"

#include "commands/control_shapes.h"

namespace fb::tool {

MorphedClip morph_controls(PoseEvaluator& evaluator, std::span<const float> controls, bool arkit_names) {
  const std::vector<ControlShape> shapes = shapes_of_controls(evaluator.model(), arkit_names);
  MorphedClip clip;
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m) {
    MorphTargets morph = targets_of(evaluator, shapes, controls, m);
    clip.error.add(
        error_of(morph, frames_of(evaluator, controls, m), evaluator.frames(controls), evaluator.parallel()));
    clip.meshes.push_back(std::move(morph));
  }
  return clip;
}

}  // namespace fb::tool
