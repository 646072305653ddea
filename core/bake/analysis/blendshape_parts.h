// Curve bases made of parts: what one control does, or what a pair or triple adds, is a small SparseBlendshapes of its
// own.
#pragma once

#include <span>

#include "bake/analysis/sparse_blendshapes.h"

namespace fb::bake {

// The index of a feature in `features`, after adding it if it is new.
std::uint32_t add_feature(std::vector<Feature>& features, const Feature& feature);

// The index in `features` of feature `index` of `from`, after adding it and what it is made of where they are new.
std::uint32_t import_feature(std::vector<Feature>& features, std::span<const Feature> from, std::uint32_t index);

// Vertices that move by more than `drop` (rig units), of 3 x vertices offsets.
SparseShape make_sparse(std::uint32_t feature, std::span<const float> offsets, double drop);

// Adds parts to the base. Features that several parts use are kept once; no two parts have shapes of one feature.
// Returns the features in the base that carry each part's shapes, part by part.
std::vector<std::vector<std::uint32_t>> append(SparseBlendshapes& base,
                                               std::span<const SparseBlendshapes* const> parts);

// Floats the shapes hold.
std::size_t stored_offsets(const SparseBlendshapes& base);

}  // namespace fb::bake
