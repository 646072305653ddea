// Linear blend skinning with bones extracted from recorded poses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "model/basis.h"
#include "model/mesh.h"
#include "model/network.h"

namespace fb::bake {

inline constexpr std::size_t bones_per_vertex = 4;  // at most

// A bone moves a vertex v by weight * (A (v - centre) + t). Its transform is the 3 x 4 matrix [A t], row-major: 12
// parameters, 0 at rest; A is a rotation minus the identity.
struct Skeleton {
  std::vector<std::array<float, 3>> centres;                       // of the bones, in the rest pose
  std::vector<std::array<std::uint32_t, bones_per_vertex>> bones;  // of each vertex, by falling weight
  std::vector<std::array<float, bones_per_vertex>> weights;        // >= 0, with sum 1

  std::size_t bone_count() const { return centres.size(); }
  std::size_t parameter_count() const { return 12 * centres.size(); }  // of all transforms of a pose
};

struct SkeletonOptions {
  std::uint32_t bones = 32;  // at most: bones without vertices are dropped
  std::size_t poses = 300;   // sampled, evenly spaced
  std::uint32_t rounds = 8;  // of alternating between transforms and weights
  // A weight that differs by 1 across an edge costs as much as this distance, over the diagonal, in every pose.
  double smoothing = 1e-3;
};

// Skinning decomposition: clusters the vertices by common rigid motion, splitting the clusters that fit worst; then
// fits rigid transforms and sparse weights in turn, after Le, Deng, "Smooth Skinning Decomposition with Rigid Bones",
// SIGGRAPH Asia 2012, with a Laplacian term that smooths weights along mesh edges. Deterministic for any number of
// threads. Memory: the sampled poses. Fails with bad_data without poses.
Skeleton extract_skeleton(const PoseSet& poses, const SkeletonOptions& options, const Parallel& parallel,
                          Progress& progress);
// The same of points in memory, poses x 3 x vertices, all of them.
Skeleton extract_skeleton(const Mesh& rest, std::span<const float> points, const SkeletonOptions& options,
                          const Parallel& parallel, Progress& progress);

// Rigid transforms of all bones that come closest to points, pose by pose: poses x parameter_count() floats. As
// BoneFitter::fit.
std::vector<float> fit_transforms(const Skeleton& skeleton, const Mesh& rest, std::span<const float> points,
                                  std::uint32_t sweeps, const Parallel& parallel);

// Sum over mesh edges of the squared difference of all weights.
double weight_roughness(const Skeleton& skeleton, const Mesh& rest);

// The displacement by one unit of each transform parameter: parameter_count() x 3 x vertices, dense. Parameter
// 12 b + 4 axis + k moves coordinate `axis` only.
std::vector<float> skinning_shapes(const Skeleton& skeleton, const Mesh& rest);

// Adds `sign` times the displacement by transforms (parameter_count() floats) to a pose (3 x vertices).
void add_skinned(const Skeleton& skeleton, const Mesh& rest, std::span<const float> transforms, float sign,
                 std::span<float> displacements);

// One linear layer without bias from features to the transforms of all bones. transforms: features x
// parameter_count().
Region transform_region(const Skeleton& skeleton, std::vector<std::uint32_t> features,
                        const std::vector<float>& transforms);

// A basis of dense columns (columns x 3 x vertices), with vertices sorted by their strongest bone so that few columns
// are non-zero in a row block.
Basis basis_by_bone(const Skeleton& skeleton, const std::vector<float>& columns);

}  // namespace fb::bake
