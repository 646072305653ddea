// What a rig does with one control, and with two and three at once, as sparse shapes: the first orders of a
// high-dimensional model representation anchored at rest (cut-HDMR; Rabitz, Alis, J. Math. Chem. 25, 1999).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/network.h"

namespace fb::bake {

// What one unit of a feature moves.
struct SparseShape {
  std::uint32_t feature = 0;            // in SparseBlendshapes::features
  std::vector<std::uint32_t> vertices;  // ascending
  std::vector<float> offsets;           // 3 a vertex, in the rig's units
};

// displacement += value * shape; displacement: 3 x vertices.
void add_scaled(const SparseShape& shape, float value, std::span<float> displacement);

struct SparseBlendshapes {
  std::vector<Feature> features;
  std::vector<SparseShape> shapes;  // no two of one feature; features used only by other features have none

  // Adds the base's displacement in each of `count` poses (count x control_count, rig values; `rest` is the rest pose)
  // to `displacements` (count x 3 x vertices), times `sign`. Thread-safe, serial.
  void add(std::span<const float> controls, std::span<const float> rest, std::size_t count, float sign,
           std::span<float> displacements) const;
};

// The values of features in one pose, in their order: what the archive's readers compute, in float.
void evaluate_features(std::span<const Feature> features, std::span<const float> controls, std::span<const float> rest,
                       std::span<float> values);

}  // namespace fb::bake
