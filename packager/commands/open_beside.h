#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <string>
#include <vector>

#include "commands/rig_options.h"

namespace fb::tool {

// Opens the source that a face is shown beside, and checks that it is of the same face: fails, naming both, where it is
// not. `clip_budget`, `test_poses`: as for RigOptions::open.
facebaker::Source open_beside(const std::string& path, const RigOptions& rigs, const facebaker::Model& model,
                              const std::string& archive, std::vector<std::string>& notes,
                              std::uint64_t clip_budget = 0, std::uint64_t test_poses = 0);

}  // namespace fb::tool
