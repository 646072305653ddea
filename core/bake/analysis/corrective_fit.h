// Finds few products and minima of features that hold what a tuple of controls does together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"

namespace fb::bake {

struct CorrectiveLimits {
  double tolerance = 0;  // largest distance at a vertex where more terms stop being worth it, rig units
  double drop = 0;       // offsets not kept, rig units
  std::uint32_t max_terms = 6;
};

// Products and minima of one feature of `tuple` and one of `single`, both local to `features`, added to them. Minima
// only where neither goes below 0, so that all vanish while any control of theirs is at rest.
std::vector<std::uint32_t> compose(std::vector<Feature>& features, std::span<const std::uint32_t> tuple,
                                   std::span<const std::uint32_t> single);

// Terms among the candidate features that, times shapes, come to `residuals` (points x 3 x vertices) at the points of
// `poses` (points x controls): picks the feature that takes most of what is left, fits the shapes of all picked by
// least squares, and goes on until the tolerance is met or a pick takes too little; then takes out those that the
// others make needless. Features that the points hardly see, and picks whose shapes cancel each other at the points,
// are left out: far from the points they could be anything. Orthogonal matching pursuit (Pati, Rezaiifar,
// Krishnaprasad, Asilomar 1993), all vertices at once. The result's features are those of its shapes and what they are
// made of.
SparseBlendshapes fit_corrective(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                                 std::span<const float> poses, std::span<const float> rest,
                                 std::span<const std::vector<float>> residuals, const CorrectiveLimits& limits);

}  // namespace fb::bake
