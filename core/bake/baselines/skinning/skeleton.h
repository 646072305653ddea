// Linear blend skinning with bones nobody drew: found in recorded poses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "model/mesh.h"

namespace fb::bake {

// What holds a vertex: at most so many bones.
inline constexpr std::size_t bones_a_vertex = 4;

// A bone moves a vertex v by weight * (A (v - centre) + t). A transform is the 3 x 4 matrix [A t], row after row: 12
// numbers, 0 at rest; A is a rotation minus the identity.
struct Skeleton {
  std::vector<std::array<float, 3>> centres;                     // of the bones, in the rest pose
  std::vector<std::array<std::uint32_t, bones_a_vertex>> bones;  // of each vertex, the strongest first
  std::vector<std::array<float, bones_a_vertex>> weights;        // >= 0, with sum 1

  std::size_t bone_count() const { return centres.size(); }
  std::size_t numbers() const { return 12 * centres.size(); }  // of all transforms of a pose
};

struct SkeletonOptions {
  std::uint32_t bones = 32;  // at most: bones that hold no vertex are dropped
  std::size_t poses = 300;   // looked at, evenly spaced
  std::uint32_t rounds = 8;  // of alternating transforms and weights
  // A weight that differs by 1 across an edge costs as much as this distance, over the diagonal, in every pose.
  double smoothing = 1e-3;
};

// Vertices are clustered by the rigid motion they share, clusters that fit worst split in two; then rigid transforms
// and sparse weights are fitted in turn, after Le, Deng, "Smooth Skinning Decomposition with Rigid Bones", SIGGRAPH
// Asia 2012, with a Laplacian term that smooths weights along the edges of the mesh. Same poses, same skeleton, for
// any number of threads. Memory: the poses looked at. Fails with bad_data if there are no poses.
Skeleton extract_skeleton(const PoseSet& poses, const SkeletonOptions& options, const Parallel& parallel,
                          Progress& progress);

// Sum over edges of the mesh of the squared difference of all weights.
double weight_roughness(const Skeleton& skeleton, const Mesh& rest);

// What one unit of each number of a transform moves: numbers() x 3 x vertices, dense. Number 12 b + 4 axis + k moves
// coordinate `axis` only.
std::vector<float> skinning_shapes(const Skeleton& skeleton, const Mesh& rest);

// Adds `sign` times what transforms (numbers() floats) move to a pose's displacements (3 x vertices).
void add_skinned(const Skeleton& skeleton, const Mesh& rest, std::span<const float> transforms, float sign,
                 std::span<float> displacements);

}  // namespace fb::bake
