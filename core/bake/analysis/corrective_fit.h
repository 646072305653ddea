// Fits a corrective, few products and minima of features with a shape each, to what some controls move together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"

namespace fb::bake {

struct CorrectiveLimits {
  double tolerance = 0;  // distance at a vertex, rig units
  double drop = 0;       // shorter offsets are dropped, rig units
  std::uint32_t max_features = 6;
};

// Adds the products, then the minima, of one feature of `first` and one of `second`, all indices into `features`, and
// returns their indices. Minima only where neither goes below 0, so that each is 0 while any of its controls is at
// rest.
std::vector<std::uint32_t> compose(std::vector<Feature>& features, std::span<const std::uint32_t> first,
                                   std::span<const std::uint32_t> second);

// Approximates `residuals` (poses x 3 x vertices) in `poses` (poses x controls) by candidate features times shapes,
// with orthogonal matching pursuit (Pati, Rezaiifar, Krishnaprasad, Asilomar 1993) on all vertices at once: the feature
// that explains most of the residual is selected and the shapes of all selected are fitted by least squares, until the
// tolerance is met or a feature explains too little; then features that the others make redundant are removed. Features
// that are small in all poses, and selections whose large shapes cancel in the poses, are left out: elsewhere they
// would be arbitrary. The result has the features of its shapes and those that these are composed of.
SparseBlendshapes fit_corrective(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                                 std::span<const float> poses, std::span<const float> rest,
                                 std::span<const std::vector<float>> residuals, const CorrectiveLimits& limits);

}  // namespace fb::bake
