#pragma once

#include <Eigen/Core>
#include <vector>

#include "bake/baselines/skinning/skeleton.h"

namespace fb::bake {

// The poses that a skeleton is extracted from, in memory.
struct PoseSample {
  std::size_t count = 0;
  std::vector<float> displacements;  // count x 3 x vertices
  Eigen::MatrixXf trajectories;      // 3 count x vertices: the same, one column a vertex

  PoseSample(const PoseSet& poses, std::size_t max_count, Progress& progress);
  // These points, count x 3 x vertices.
  PoseSample(const Mesh& rest, std::span<const float> points);
};

// Rigid transforms of the bones in every pose (count x parameter_count()), starting from `transforms` if not empty.
void fit_poses(const Skeleton& skeleton, const Mesh& rest, const PoseSample& poses, std::uint32_t sweeps,
               std::vector<float>& transforms, const Parallel& parallel);

// How well the bones explain the motion of vertices, summed over all poses. Products of the transforms are computed
// once, so the cost of a query does not depend on the number of poses.
class BoneMotion {
 public:
  BoneMotion(const Skeleton& skeleton, const Mesh& rest, const PoseSample& poses, const std::vector<float>& transforms,
             const Parallel& parallel);

  // Squared error of moving a vertex by one bone, up to a constant of the vertex:
  // |motion by the bone|^2 - 2 (motion by the bone) . (motion of the vertex).
  double error(std::size_t vertex, std::size_t bone) const;
  // The quadratic form of the weights w: |sum w_b (motion by b) - (motion of the vertex)|^2 = w' Q w - 2 w' r + const.
  void quadratic_form(std::size_t vertex, Eigen::MatrixXd& quadratic, Eigen::VectorXd& linear) const;

 private:
  Eigen::Vector4d local_position(std::size_t vertex, std::size_t bone) const;

  const Skeleton* skeleton_;
  const Mesh* rest_;
  Eigen::MatrixXd products_;     // of transforms with transforms: 4 bones x 4 bones
  Eigen::MatrixXf projections_;  // of transforms with the vertices' motion: 4 bones x vertices
};

}  // namespace fb::bake
