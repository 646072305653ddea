// Poses of a live rig that only the controls of one region move, to train its network on beside those of the whole
// face. Of these, few have the controls together that matter to a region: of 8,000 of the sample face, 149 hold half of
// what the blendshapes leave of the tongue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/regions/find_regions.h"
#include "bake/regions/local_basis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// How many poses of single regions are drawn in all, for a face that is trained on so many poses: sixteen times as
// many, but no more than make 150,000 with these. A table of docs/experiments.md says what other numbers bring.
std::size_t region_pose_count(std::size_t poses);

// Divides poses over regions by the root of the squared error that is expected of each.
std::vector<std::size_t> region_pose_counts(std::size_t poses, std::span<const double> errors);

// Poses of one region, evaluated.
struct RegionPoses {
  std::vector<float> controls;      // poses x controls
  std::vector<float> coefficients;  // of the region's basis: poses x LocalBasis::count
};

// Draws `count` poses of a region, the face's number `number`, and evaluates them. In a pose, a control is the more
// often away from rest the further it moves what the blendshapes leave of the region. `base`: these blendshapes, of
// whose residual the basis is. Depends on rig, seed and number, not on threads. Fails as RigEvaluator::evaluate_each
// does.
RegionPoses region_poses(RigEvaluator& rig, const SparseBlendshapes& base, const FaceRegion& region,
                         const LocalBasis& basis, std::size_t number, std::size_t count, std::uint64_t seed,
                         EvaluationStage& stage);

}  // namespace fb::bake
