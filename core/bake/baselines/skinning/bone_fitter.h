#pragma once

#include <Eigen/Core>
#include <span>

#include "bake/baselines/skinning/skeleton.h"

namespace fb::bake {

// Rigid transforms of all bones for displacements of poses. Everything it needs of the mesh is a few small matrices of
// products of the columns c = weight * (v - centre, 1).
class BoneFitter {
 public:
  BoneFitter(const Skeleton& skeleton, const Mesh& rest);

  // Fits a pose (displacements: 3 x vertices) by `sweeps` over the bones, each bone's transform the best while the
  // others stay: a weighted Procrustes problem (Kabsch, Acta Cryst. A32, 1976). Begins with what `transforms`
  // (numbers() floats) holds if `warm`, otherwise with every bone for itself. Thread-safe.
  void fit(std::span<const float> displacements, std::span<float> transforms, bool warm, std::uint32_t sweeps) const;

 private:
  const Skeleton* skeleton_;
  const Mesh* rest_;
  Eigen::MatrixXd products_;  // of columns, 4 bones x 4 bones
  Eigen::MatrixXd alone_;     // 4 x 4 bones: of a bone's columns with (v - centre, 1) itself
  double stiffness_;          // keeps bones of nearly no extent from turning
};

}  // namespace fb::bake
