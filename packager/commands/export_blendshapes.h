#pragma once

#include <cstdint>
#include <string>

#include "base/progress.h"
#include "commands/export_result.h"
#include "commands/pose_controls.h"
#include "commands/pose_evaluator.h"
#include "commands/target_limits.h"

namespace fb::tool {

struct BlendshapeExport {
  std::size_t shapes = 64;   // at most
  bool arkit_names = false;  // names by ARKit where controls say so
  TargetOptions targets;     // of a clip
  std::size_t poses = 300;   // drawn, to choose shapes by and to measure on
  std::uint64_t seed = 1;
  std::string licence;  // text; may be empty
};

// Writes a .glb with the blendshapes that move the face most in drawn poses, one for an end of a control's range, named
// as shapes_of_both_ends has it. A clip becomes an animation of their weights, and of more targets, "correction0" and
// so on, which bring it within the tolerance.
ExportResult export_blendshapes(PoseEvaluator& evaluator, const Poses& poses, const BlendshapeExport& options,
                                const std::string& path, Progress& progress);

}  // namespace fb::tool
