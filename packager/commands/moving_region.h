#pragma once

#include <optional>

#include "commands/pose_evaluator.h"
#include "render/camera.h"

namespace fb::tool {

// Of a face that is a small part of a body, the box of what its controls move, each alone to both ends of its range;
// none where a picture shows the whole (MovingPart::region).
std::optional<BoundingBox> moving_region(PoseEvaluator& evaluator);

}  // namespace fb::tool
