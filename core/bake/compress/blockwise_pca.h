// Blockwise PCA: a basis rewritten so that a pose reads less of it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "model/face_model.h"

namespace fb::bake {

struct BlockwisePcaOptions {
  // 128 at the same error (`bench_packing`, "block=128" with 0.7 of the recipe's drop) makes archives 1 to 3 % smaller;
  // poses of the sample face take 0.98 of the time with AVX-512 and 1.02 with AVX2.
  std::uint32_t block_vertices = 64;
  double threshold = 2e-5;  // over D: a block keeps directions with a larger root mean square motion per vertex
};

struct BlockwiseModel {
  FaceModel model;
  // Typical size of each coefficient: its root mean square over the poses of the covariance; for direct ones as given.
  std::vector<float> coefficient_sizes;
};

// Vertices are reordered so that neighbours of one region follow each other and are cut into blocks, a row block of the
// basis each. In each block the columns of a region are replaced by fewer of the block's own: the principal directions
// of the region's motion there (orthonormal, by falling variance), and the projection is merged into the region's last,
// linear layer. A region that would not have fewer numbers so (output layer and basis), or whose last layer is not
// linear, keeps its columns. Kept columns and direct columns are left out of the row blocks where they are 0.
class BlockwisePca {
 public:
  // Finds all directions. `covariance`: one matrix per region, outputs x outputs: the mean over poses of the products
  // of its coefficients. `direct_sizes`: typical sizes of the direct coefficients; empty: 1. The result does not depend
  // on the number of threads. Fails with invalid_argument on a covariance of another size, not_finite on NaN in it.
  BlockwisePca(const FaceModel& model, std::span<const std::vector<float>> covariance, std::uint32_t block_vertices,
               const Parallel& parallel, std::span<const float> direct_sizes = {});
  ~BlockwisePca();

  // Keeps the directions above a threshold, see BlockwisePcaOptions. The result has the model's features, regions and
  // hidden layers, without regions that have no direction left; with threshold 0 it evaluates like the model in all
  // poses of the covariance. Thread-safe.
  BlockwiseModel truncated(double threshold) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// BlockwisePca(...).truncated(options.threshold).
BlockwiseModel blockwise_pca(const FaceModel& model, std::span<const std::vector<float>> covariance,
                             const BlockwisePcaOptions& options, const Parallel& parallel = {});

}  // namespace fb::bake
