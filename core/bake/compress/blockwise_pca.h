#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "model/face_model.h"

namespace fb::bake {

struct BlockwisePcaOptions {
  std::uint32_t block_vertices = 64;
  double threshold = 2e-5;  // over D: a chunk keeps the directions whose root mean square motion a vertex is larger
};

struct BlockwiseModel {
  FaceModel model;
  // Typical size of each coefficient: its root mean square over the poses of the covariance; for direct ones as given.
  std::vector<float> coefficient_sizes;
};

// Rewrites a basis so that a pose reads less of it: vertices are put in an order where neighbours of one region lie
// together and cut into chunks, a row group each; in each chunk the columns of a region become fewer of the chunk's
// own, the principal directions of that region's motion there (orthonormal, by falling motion), and the rotation is
// merged into the region's last, linear layer. A region that would not hold fewer numbers so (output layer and basis),
// or whose last layer is not linear, keeps its columns. They and direct columns are left out of the chunks they do not
// move.
class BlockwisePca {
 public:
  // Finds all directions. `covariance`: one matrix a region, outputs x outputs: the mean over poses of the products of
  // its coefficients. `direct_sizes`: typical sizes of the direct coefficients; empty: 1. The same for any thread
  // count; fails with invalid_argument on a covariance of another size.
  BlockwisePca(const FaceModel& model, std::span<const std::vector<float>> covariance, std::uint32_t block_vertices,
               const Parallel& parallel, std::span<const float> direct_sizes = {});
  ~BlockwisePca();

  // Keeps those above a threshold: see BlockwisePcaOptions. The result has the model's features, regions and hidden
  // layers, less the regions that move nothing by the threshold; with threshold 0 it moves as the model did in every
  // pose the covariance was made of. Thread-safe.
  BlockwiseModel truncated(double threshold) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// Both at once.
BlockwiseModel blockwise_pca(const FaceModel& model, std::span<const std::vector<float>> covariance,
                             const BlockwisePcaOptions& options, const Parallel& parallel = {});

}  // namespace fb::bake
