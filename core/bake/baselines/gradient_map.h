#pragma once

#include <Eigen/SparseCholesky>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_rows.h"
#include "model/mesh.h"

namespace fb::bake {

// Deformation gradients of a mesh in the feature space of PCA, with as many values as the mesh has coordinates.
//
// In the plane of a triangle, the gradient minus the identity is linear in the displacements. The products of the
// gradients of two poses d and e, summed over triangles by area, are d' L e with L the cotangent Laplacian (Botsch,
// Sorkine, "On Linear Variational Surface Deformation Methods", TVCG 2008). With the Cholesky factorisation L = R'R,
// the values R d have the same products and lengths, so their principal components are those of the gradients, and R^-1
// is the Poisson solve that reconstructs positions. L is singular for translations of a connected component: the mean
// translation of each is three more values, in units of `translation_length`. A vertex without a polygon is a component
// of its own.
class GradientMap {
 public:
  explicit GradientMap(const Mesh& rest);

  // The two directions, each the inverse of the other: 3 x vertices floats. Thread-safe.
  void to_gradients(std::span<const float> displacements, std::span<float> gradients) const;
  void to_displacements(std::span<const float> gradients, std::span<float> displacements) const;

  std::size_t component_count() const { return pinned_.size(); }

  // Over the diagonal: a translation by this distance counts as much as a gradient of 1 everywhere.
  static constexpr double translation_length = 0.1;

 private:
  std::size_t vertices_;
  std::vector<std::uint32_t> component_;  // of each vertex
  std::vector<double> area_share_;        // of each vertex in its component
  std::vector<std::uint32_t> pinned_;     // of each component: the vertex that the mean translation replaces
  std::vector<double> weight_;            // of each component's mean translation
  std::vector<std::uint32_t> free_;       // all other vertices: the unknowns of the factorisation
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

// The gradient values of poses. The map must outlive it.
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
