#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/linalg/kernels.h"

namespace fb::bake {

// A copy of sparse blendshapes for adding them to many poses: offsets are ordered by blocks of consecutive coordinates,
// so that the sums of a block in a few poses stay in registers and its offsets in the caches. Memory: the offsets,
// filled up with zeros to whole blocks.
class BlockedBlendshapes {
 public:
  // vertices: of the mesh. The shapes may be destroyed afterwards.
  BlockedBlendshapes(const SparseBlendshapes& shapes, std::size_t vertices);

  // See SparseBlendshapes::add. The displacements of a pose have the same bits whatever poses are beside it, and differ
  // by rounding only from those of SparseBlendshapes, for which shapes are added up in another order.
  void add(std::span<const float> controls, std::span<const float> rest, std::size_t count, float sign,
           std::span<float> displacements) const;

 private:
  // Values of the features in a few poses, and which are active in one of them.
  struct Values {
    std::vector<SixteenFloats> values;  // of each feature
    std::vector<std::uint8_t> active;
  };
  Values evaluate(std::span<const float> controls, std::span<const float> rest, std::size_t count) const;

  std::size_t size_;  // 3 x vertices
  std::vector<Feature> features_;
  std::vector<std::size_t> first_;            // of each block, in the next: one more than blocks
  std::vector<std::uint32_t> term_features_;  // of a block's shapes
  std::vector<SixteenFloats> offsets_;        // of these, in the block
};

}  // namespace fb::bake
