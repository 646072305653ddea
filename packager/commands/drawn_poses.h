#pragma once

#include <cstdint>
#include <facebaker/facebaker.hpp>
#include <vector>

#include "base/random_streams.h"

namespace fb::tool {

// Random poses, poses x controls: in each, 15 % of the controls, and at least one, are anywhere in their ranges, and
// the others at rest. The same for the same seed and use of it.
std::vector<float> draw_poses(const facebaker::Model& model, std::size_t poses, std::uint64_t seed, Stream use);

}  // namespace fb::tool
