#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/regions/find_regions.h"
#include "bake/regions/residual.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct LocalBasisOptions {
  // Truncation error: largest distance at a vertex of any pose fitted, over D. The number of components follows from it
  // rather than from the variance, which bounds no single vertex.
  double max_error = 1e-3;
  std::size_t max_components = 256;  // a region
  std::size_t max_fit_poses = 6000;  // evenly spaced; the basis is fitted to these
};

// Orthonormal blendshapes of one region's part of the residual (blend weight x residual), by falling variance.
struct LocalBasis {
  std::size_t rows = 0, count = 0;      // 3 x the region's vertices; components
  std::vector<float> components;        // count x rows
  std::vector<float> coefficients;      // poses x count: of every pose, fitted or not
  double max_error = 0, rms_error = 0;  // truncation error at a vertex, over D, on the poses fitted
};

// One basis a region, by randomised subspace iteration (Halko, Martinsson, Tropp, SIAM Review 2011), fitted to
// `to_fit`; the coefficients are those of `all`, of the same source. The poses to fit are read about twice and all
// poses once, for all regions together. Keeps the fewest components whose truncation error is at most max_error: a
// multiple of 8 unless the poses span fewer, at least 1, at most max_components. Memory: the coefficients, about three
// matrices of (rows of all regions + poses to fit) x max_components, and 64 MiB of poses. Same bits for any number of
// threads. Fails with invalid_argument without poses or components, or on a region whose
// vertices are missing or out of range.
std::vector<LocalBasis> local_bases(const PoseRows& to_fit, const PoseRows& all, const std::vector<FaceRegion>& regions,
                                    const LocalBasisOptions& options, const Parallel& parallel, Progress& progress);
// The same, fitted to all of them.
inline std::vector<LocalBasis> local_bases(const PoseRows& residual, const std::vector<FaceRegion>& regions,
                                           const LocalBasisOptions& options, const Parallel& parallel,
                                           Progress& progress) {
  return local_bases(residual, residual, regions, options, parallel, progress);
}

// The coefficients (poses x count) of poses of the residual (poses x 3 x vertices of the mesh) in the basis of a
// region.
void project_poses(const FaceRegion& region, const LocalBasis& basis, std::span<const float> residual,
                   std::size_t poses, float* coefficients);

}  // namespace fb::bake
