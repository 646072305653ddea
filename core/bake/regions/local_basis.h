#pragma once

#include <cstddef>
#include <vector>

#include "bake/regions/find_regions.h"
#include "bake/regions/residual.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb {

struct LocalBasisOptions {
  double max_error = 1e-3;  // largest distance at a vertex of any pose looked at, over D
  std::size_t max_components = 256;
  std::size_t poses_to_fit = 6000;  // evenly spaced
};

// Blendshapes of one region's share of the residual (weight x residual), orthonormal, by falling variance.
struct LocalBasis {
  std::size_t rows = 0, count = 0;      // rows: 3 x the region's vertices
  std::vector<float> components;        // count x rows
  std::vector<float> coefficients;      // poses x count: every pose of the residual
  double max_error = 0, rms_error = 0;  // what is lost, over D, on the poses fitted
};

// One basis a region. Reads the poses twice: some to fit, all to project.
std::vector<LocalBasis> local_bases(const PoseRows& residual, const std::vector<FaceRegion>& regions,
                                    const LocalBasisOptions& options, const Parallel& parallel, Progress& progress);

}  // namespace fb
