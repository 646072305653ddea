#pragma once

#include <Eigen/Core>
#include <vector>

#include "bake/baselines/skinning/skeleton.h"

namespace fb::bake {

// Some poses, small enough to hold.
struct HoldoutSet {
  std::size_t count = 0;
  std::vector<float> displacements;  // count x 3 x vertices
  Eigen::MatrixXf trajectories;      // 3 x count, vertices: the same, a column a vertex

  HoldoutSet(const PoseSet& poses, std::size_t most, Progress& progress);
};

// Transforms of the bones in every pose (count x numbers()): begun from `transforms` if they are there.
void fit_poses(const Skeleton& skeleton, const Mesh& rest, const HoldoutSet& poses, std::uint32_t sweeps,
               std::vector<float>& transforms, const Parallel& parallel);

// What each bone would do to a vertex on its own, against what the vertex does: sums over all poses. Products of the
// transforms are made once, so asking for a vertex costs nothing that grows with the poses.
class BoneMotion {
 public:
  BoneMotion(const Skeleton& skeleton, const Mesh& rest, const HoldoutSet& poses, const std::vector<float>& transforms,
             const Parallel& parallel);

  // |what bone `b` does|^2 - 2 (what bone b does) . (what the vertex does): how badly it fits, up to a constant.
  double misfit(std::size_t vertex, std::size_t bone) const;
  // The whole quadratic form: |sum w_b (what b does) - (what the vertex does)|^2 = w'products w - 2 w'against + ...
  void form(std::size_t vertex, Eigen::MatrixXd& products, Eigen::VectorXd& against) const;

 private:
  Eigen::Vector4d place(std::size_t vertex, std::size_t bone) const;

  const Skeleton* skeleton_;
  const Mesh* rest_;
  Eigen::MatrixXd products_;  // 4 bones x 4 bones
  Eigen::MatrixXf against_;   // 4 bones x vertices
};

}  // namespace fb::bake
