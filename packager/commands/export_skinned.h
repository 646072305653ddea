#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <string>

#include "commands/export_result.h"
#include "commands/pose_controls.h"
#include "commands/pose_evaluator.h"

namespace fb::tool {

struct SkinnedExport {
  std::uint32_t joints = 32;  // at most
  std::size_t shapes = 16;    // at most
  bool arkit_names = false;
  std::size_t poses = 300;  // drawn, to fit to and to measure on, or of a clip to fit to
  std::uint64_t seed = 1;
  std::string licence;  // text; may be empty
};

// Writes a .glb of joints with four skin weights a vertex and a few blendshapes, fitted to drawn poses or to those of a
// clip, which becomes an animation of both. Without a clip there is an animation a control end, named as
// shapes_of_both_ends has it, from rest at second 0 to the end at second 1.
ExportResult export_skinned(PoseEvaluator& evaluator, const facebaker::Archive& archive, const Poses& poses,
                            const SkinnedExport& options, const std::string& path);

}  // namespace fb::tool
