// Sparse blendshapes weighted by features of the controls: one control, or two, three or four together. With the
// correctives fitted to differences, these are the first orders of a high-dimensional model representation anchored at
// rest (cut-HDMR; Rabitz, Alis, J. Math. Chem. 25, 1999). Called "base" where networks learn what it leaves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/network.h"
#include "model/rig_schema.h"

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

  // Adds the displacement of all shapes in each of `count` poses (count x controls, rig values; `rest` is the rest
  // pose) to `displacements` (count x 3 x vertices), times `sign`. Thread-safe, serial. Many poses: see
  // BlockedBlendshapes.
  void add(std::span<const float> controls, std::span<const float> rest, std::size_t count, float sign,
           std::span<float> displacements) const;
};

// What blendshapes do to some of the vertices (ascending), which are then numbered as they come there. Their features
// are the same.
SparseBlendshapes part_of(const SparseBlendshapes& blendshapes, std::span<const std::uint32_t> vertices);

// Values of features in one pose, in their order, in float as the archive's readers compute them.
void evaluate_features(std::span<const Feature> features, std::span<const float> controls, std::span<const float> rest,
                       std::span<float> values);

// How much and how often a feature is active in some poses.
struct FeatureUsage {
  double square = 0;  // mean square, over all poses
  double active = 0;  // share of the poses where it is not 0
};

// One for every feature; controls: poses x controls, rig values.
std::vector<FeatureUsage> feature_usage(const std::vector<Feature>& features, const RigSchema& schema,
                                        std::span<const float> controls);

}  // namespace fb::bake
