#pragma once

#include <cstddef>
#include <vector>

#include "bake/rig/pose_rows.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Principal components about the rest pose, whose rows are 0 (not about their mean: the rest pose must have
// coefficients 0).
struct PrincipalComponents {
  std::size_t rows = 0;             // numbers a pose
  std::size_t count = 0;            // components
  std::vector<float> components;    // count x rows, orthonormal, by falling variance
  std::vector<float> coefficients;  // poses x count: every pose of the set in these components
  double total = 0, captured = 0;   // mean square of a pose: all of it, and inside the components
};

// The fewest components that hold `fraction` (0 to 0.99999: products are in float) of the sum of squares of all poses.
//
// Streams: poses are read in blocks, never held together, so memory is a few (rows x components) matrices plus the
// coefficients. Randomised subspace iteration (Halko, Martinsson, Tropp, SIAM Review 2011) started from the exact
// components of an evenly spaced sample, then a Rayleigh-Ritz step over all poses that also measures exactly what the
// subspace holds; repeated with a larger subspace while that is too little.
PrincipalComponents principal_components(const PoseRows& poses, double fraction, const Parallel& parallel,
                                         Progress& progress);

}  // namespace fb::bake
