#pragma once

#include <Eigen/SparseCholesky>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_rows.h"
#include "model/mesh.h"

namespace fb::bake {

// Deformation gradients of a mesh, in as few numbers as it has coordinates.
//
// In the plane of a triangle the gradient minus the identity is linear in the displacements, and the products of the
// gradients of two poses, summed over triangles by area, are d' L e with L the cotangent Laplacian (Botsch, Sorkine,
// "On Linear Variational Surface Deformation Methods", TVCG 2008). With L = R'R the numbers R d have the same products
// and lengths, so their principal components are those of the gradients, and R^-1 is the Poisson solve that rebuilds
// positions. L does not see a connected component move as a whole: its mean translation is three numbers more, in units
// of `translation_length`. A vertex without a polygon is a component of its own.
class GradientMap {
 public:
  explicit GradientMap(const Mesh& rest);

  // Both ways: 3 x vertices floats. Each undoes the other. Thread-safe.
  void to_gradients(std::span<const float> displacements, std::span<float> gradients) const;
  void to_displacements(std::span<const float> gradients, std::span<float> displacements) const;

  std::size_t component_count() const { return held_.size(); }

  // Over the diagonal: a component that moves so far counts as if its gradient were 1 everywhere.
  static constexpr double translation_length = 0.1;

 private:
  std::size_t vertices_;
  std::vector<std::uint32_t> component_;  // of each vertex
  std::vector<double> share_;             // of each vertex in its component's mean
  std::vector<std::uint32_t> held_;       // of each component: the vertex whose place the mean translation takes
  std::vector<double> weight_;            // of each component's translation
  std::vector<std::uint32_t> free_;       // all other vertices, in the order of the factor's unknowns
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

// The gradients of poses. The map must outlive it.
class GradientRows final : public PoseRows {
 public:
  GradientRows(PoseSet poses, const GradientMap& map) : PoseRows(std::move(poses)), map_(&map) {}
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const override;
  std::unique_ptr<PoseRows> subsampled(std::size_t count) const override {
    return std::make_unique<GradientRows>(poses().subsampled(count), *map_);
  }

 private:
  const GradientMap* map_;
};

}  // namespace fb::bake
