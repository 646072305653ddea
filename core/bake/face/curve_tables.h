#pragma once

#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/regions/find_regions.h"
#include "bake/regions/local_basis.h"
#include "bake/rig/pose_set.h"
#include "model/network.h"

namespace fb::bake {

// The curve of one control, of many knots, as a table: a region whose network is one linear layer, from features of
// that control to the coefficients of a few shapes.
struct CurveTable {
  FaceRegion region;
  LocalBasis basis;
  Region network;  // its features are indices into SparseBlendshapes::features
};

// Takes from the base the shapes of every control that has more than two dozen of its own, where half as many do: by
// principal components of the shapes, as many as keep each within `tolerance` at a vertex, over the diagonal. The
// base's features stay. A control that oscillates moves its vertices along few directions, however many knots it has.
std::vector<CurveTable> take_curve_tables(SparseBlendshapes& base, const PoseSet& poses, double tolerance);

}  // namespace fb::bake
