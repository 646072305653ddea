#pragma once

#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/regions/find_regions.h"
#include "bake/regions/local_basis.h"
#include "model/face_model.h"

namespace fb::bake {

// The block-sparse basis of a face: one column for each sparse blendshape, then one for each component of every region.
Basis assemble_basis(std::size_t vertices, const SparseBlendshapes& base, std::span<const FaceRegion> regions,
                     std::span<const LocalBasis> bases);

}  // namespace fb::bake
