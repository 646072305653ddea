#pragma once

#include <cstddef>
#include <vector>

#include "bake/regions/find_regions.h"
#include "bake/regions/residual.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

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

// One basis a region, by randomised subspace iteration (Halko, Martinsson, Tropp, SIAM Review 2011): the poses to fit
// are read about two times and all of them once, for all regions together. Of the components searched, which are a
// little more than max_components, the fewest that lose no more than max_error are kept (a multiple of 8, unless the
// poses do not span so many); at least one. Besides the coefficients it needs about three matrices of (rows of all
// regions + poses to fit) x max_components and 64 MiB of poses. Same bits for any number of threads. Fails on no poses,
// no components or a region that names no vertex.
std::vector<LocalBasis> local_bases(const PoseRows& residual, const std::vector<FaceRegion>& regions,
                                    const LocalBasisOptions& options, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
