#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Recorded poses seen as what is left of them once a base is taken away.
struct RecordedPoses {
  const PoseSet* poses;
  std::span<const float> controls;      // of all poses of the set
  std::span<const float> rest;          // pose
  std::span<const std::size_t> picked;  // ascending
  const SparseBlendshapes* base;

  std::span<const float> pose(std::size_t i) const { return controls.subspan(picked[i] * rest.size(), rest.size()); }
  // Displacements left over in picked poses [first, first + count): count x 3 x vertices.
  void read(std::size_t first, std::size_t count, std::span<float> left, const Parallel& parallel) const;
};

// Shapes of some features that come closest to what is left of the poses, in the sense of least squares with `ridge`
// (one a feature) times the mean square of all features added to the diagonal. Offsets within four standard errors of
// 0, as the poses tell them, are left out: what is noise would else move every vertex.
std::vector<SparseShape> regress(const RecordedPoses& recorded, std::span<const Feature> features,
                                 std::span<const std::uint32_t> carriers, std::span<const double> ridge,
                                 const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
