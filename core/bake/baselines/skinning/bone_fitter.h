#pragma once

#include <Eigen/Core>
#include <span>

#include "bake/baselines/skinning/skeleton.h"

namespace fb::bake {

// Fits rigid transforms of all bones to the displacements of poses. Keeps small matrices of products of the columns
// c = weight * (v - centre, 1) in place of the mesh.
class BoneFitter {
 public:
  BoneFitter(const Skeleton& skeleton, const Mesh& rest);

  // Fits one pose (displacements: 3 x vertices) by `sweeps` of coordinate descent: each bone in turn gets the best
  // rigid transform while the others stay, a weighted Procrustes problem (Kabsch, Acta Cryst. A32, 1976). Starts from
  // `transforms` (parameter_count() floats) if `warm_start`, else from each bone fitted on its own. Thread-safe.
  void fit(std::span<const float> displacements, std::span<float> transforms, bool warm_start,
           std::uint32_t sweeps) const;

 private:
  const Skeleton* skeleton_;
  const Mesh* rest_;
  Eigen::MatrixXd products_;         // of columns: 4 bones x 4 bones
  Eigen::MatrixXd single_products_;  // 4 x 4 bones: of each bone's columns with (v - centre, 1) itself
  double stiffness_;                 // keeps bones of almost no extent from rotating
};

}  // namespace fb::bake
