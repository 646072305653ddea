#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "bake/analysis/blocked_blendshapes.h"
#include "bake/rig/pose_rows.h"
#include "base/parallel.h"

namespace fb::bake {

// Recorded displacements minus those of the sparse blendshapes: what region networks learn.
class Residual final : public PoseRows {
 public:
  Residual(PoseSet poses, std::shared_ptr<const BlockedBlendshapes> base);
  Residual(PoseSet poses, const SparseBlendshapes& base);  // the same with a copy of the blendshapes

  // Poses [first, first + count): count x rows() floats, on all threads of `parallel` if the source is thread-safe. The
  // rest pose is exactly 0. Fails with invalid_argument on a range outside the set.
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const override;
  std::unique_ptr<PoseRows> subsampled(std::size_t count) const override;

 private:
  std::shared_ptr<const BlockedBlendshapes> base_;
  std::vector<float> rest_;
};

}  // namespace fb::bake
