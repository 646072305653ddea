// Few morph targets for many frames.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "base/parallel.h"
#include "export/morph_targets.h"

namespace fb::tool {

// Gives frames `first` to `first + count` of a mesh: displacements from rest, 3 x vertices a frame.
using FrameReader = std::function<std::vector<float>(std::size_t first, std::size_t count)>;

// Calls `body` with blocks of frames, in order: the index of the first, and their displacements.
void for_frame_blocks(const FrameReader& read, std::size_t frames,
                      const std::function<void(std::size_t first, std::size_t count, std::span<const float>)>& body);

// The fewest principal components of the frames from which no vertex of a frame is further than `tolerance` (a
// distance), as morph targets with weights of at most 1. spanning: targets whose sums the frames are (weights are not
// read), not more than there are frames. None are needed where nothing moves by more than the tolerance. Where
// rounding alone exceeds it, all components are given.
MorphTargets principal_targets(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                               double tolerance, const Parallel& parallel);

// The first `count` principal components of the frames, or fewer where there are no more, likewise.
MorphTargets leading_targets(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                             std::size_t count, const Parallel& parallel);

}  // namespace fb::tool
