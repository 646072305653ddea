#pragma once

#include <cstddef>
#include <vector>

#include "bake/rig/pose_rows.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Principal components about the rest pose, whose values are 0. Not about the mean, as the rest pose must have
// coefficients 0.
struct PrincipalComponents {
  std::size_t rows = 0;             // values a pose
  std::size_t count = 0;            // components
  std::vector<float> components;    // count x rows, orthonormal, by falling variance
  std::vector<float> coefficients;  // poses x count: every pose of the set in these components
  double total = 0, captured = 0;   // mean squared length of a pose, and of its projection
};

// The fewest components that hold `fraction` (0 to 0.99999: products are in float) of the sum of squares of all poses.
//
// Randomised subspace iteration (Halko, Martinsson, Tropp, SIAM Review 2011): starts from the exact components of an
// evenly spaced sample, then makes a Rayleigh-Ritz step over all poses, which also measures the sum of squares in the
// subspace; repeats with a larger subspace while that is too small. Poses are read in blocks: memory is a few
// rows x components matrices and the coefficients. Fails with bad_data without poses, or if no pose moves a vertex.
PrincipalComponents principal_components(const PoseRows& poses, double fraction, const Parallel& parallel,
                                         Progress& progress);

}  // namespace fb::bake
