#include "commands/moving_region.h"

#include <vector>

#include "render/moving_part.h"

namespace fb::tool {

std::optional<BoundingBox> moving_region(PoseEvaluator& evaluator) {
  const facebaker::Model& model = evaluator.model();
  std::vector<float> pose = model.rest_controls();
  MovingPart part(evaluator.character().mesh);
  for (std::uint32_t c = 0; c < model.control_count(); ++c) {
    const fb_control control = model.control(c);
    for (const float value : {control.minimum, control.maximum}) {
      if (value == control.rest) continue;
      pose[c] = value;
      part.add(evaluator.positions(pose));
    }
    pose[c] = control.rest;
  }
  return part.region();
}

}  // namespace fb::tool
