#pragma once

#include "bake/baselines/skinning/bone_motion.h"
#include "bake/regions/surface_graph.h"

namespace fb::bake {

// New weights of all vertices for the bones' motion, starting from those the skeleton has: the best non-negative ones
// with sum 1, at most bones_a_vertex, where a weight that differs by 1 from a neighbour's costs `smoothing`.
void solve_weights(Skeleton& skeleton, const BoneMotion& motion, const SurfaceGraph& graph, double smoothing,
                   const Parallel& parallel);

// Minimises w'form w - 2 w'against over w >= 0 with sum 1: an active-set method after Lawson, Hanson, "Solving Least
// Squares Problems", 1974; the sum is held by a stiff penalty.
Eigen::VectorXd solve_simplex(Eigen::MatrixXd form, Eigen::VectorXd against);

}  // namespace fb::bake
