// Sparse blendshapes assembled from parts: the curve of one control, or a corrective, is a small SparseBlendshapes of
// its own.
#pragma once

#include <span>

#include "bake/analysis/sparse_blendshapes.h"

namespace fb::bake {

// Index of a feature in `features`; added if it is new. Linear search.
std::uint32_t add_feature(std::vector<Feature>& features, const Feature& feature);

// Index in `features` of feature `index` of `from`; it and the features it is composed of are added where they are new.
std::uint32_t import_feature(std::vector<Feature>& features, std::span<const Feature> from, std::uint32_t index);

// The vertices whose offset (of 3 x vertices) is longer than `drop`, rig units.
SparseShape make_sparse(std::uint32_t feature, std::span<const float> offsets, double drop);

// Adds parts to the base. Features that several parts use become one; no two parts may have shapes of one feature.
// Returns for each part the features, in the base, of its shapes.
std::vector<std::vector<std::uint32_t>> append(SparseBlendshapes& base,
                                               std::span<const SparseBlendshapes* const> parts);

// Number of floats in the offsets of all shapes.
std::size_t stored_offsets(const SparseBlendshapes& base);

}  // namespace fb::bake
