// How much of a joint's motion is rounding.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "bake/rig/gltf/gltf_joints.h"
#include "bake/rig/gltf/joint_controls.h"

namespace fb::bake {

// Sets depth, far, reach and extent of nodes that are joints. `points`: of all vertices, before skinning.
void measure_nodes(std::vector<MovedNode>& nodes, const GltfScene& scene, const GltfJoints& joints,
                   std::span<const float> points);

// The step between neighbouring values of the numbers in which the animations of a file store rotations: of floats near
// 1 that of floats, 2^-23; of normalised integers theirs; and of floats that were rounded before they were stored what
// the lengths of the quaternions show, which miss 1 by a step over 5.1 in the median.
double rotation_step(const GltfFile& file);

// Ranges up to which the offsets of a node are rounding, not motion.
struct JointNoise {
  double translation = 0;  // in its parent
  double turn = 0;         // radians
  double scale = 0;
};

// An exporter finds a joint in its parent from matrices in the scene, each of which is the product of those above it,
// in floats. With the unit roundoff u = 2^-24 and the depth d, an entry of such a matrix is wrong by up to 4 d u, on
// top of half a step of what is stored. So the range of noise, to either side, is
//
//   rotation     8 (step / 2 + 4 d u)                  radians: 4 numbers of a quaternion, of half the angle
//   scale        2 (u + 4 d u) |scale|
//   translation  2 (u |translation| + 4 d u far)       far: to the joints above
//
// but no less than what moves no vertex by more than the rounding of its position: 2 u extent, over the distance of
// vertices from the joint for rotation and scale. `translation`, `scale`: the largest of the node.
JointNoise noise_of(const MovedNode& node, double translation, double scale, double rotation_step);

}  // namespace fb::bake
