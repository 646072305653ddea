#pragma once

#include "bake/baselines/skinning/bone_motion.h"
#include "bake/regions/surface_graph.h"

namespace fb::bake {

// Solves for the weights of all vertices given the bones' motion: non-negative with sum 1, at most bones_per_vertex
// non-zero. A difference of 1 from a neighbour's current weight costs `smoothing`.
void solve_weights(Skeleton& skeleton, const BoneMotion& motion, const SurfaceGraph& graph, double smoothing,
                   const Parallel& parallel);

// Minimises w' Q w - 2 w' r over the simplex w >= 0, sum w = 1: the active-set method of Lawson, Hanson, "Solving Least
// Squares Problems", 1974, with the sum as a stiff penalty.
Eigen::VectorXd solve_simplex(Eigen::MatrixXd quadratic, Eigen::VectorXd linear);

}  // namespace fb::bake
