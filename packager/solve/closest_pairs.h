// Pairs of closest points of two surfaces, or of points and a surface, and how well they fit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "solve/sampled_surface.h"
#include "solve/similarity.h"

namespace fb::tool {

// A point of what is aligned, moved, and its partner on the face.
struct ClosestPair {
  Vector3 from, to;
  Vector3 normal;    // of the face, unit
  bool fits = true;  // neither at a border nor with normals that are 60 degrees apart
  float distance = 0;
};

// What the closest pairs of one direction say: points of one side, each with its closest point of the other.
struct PairStatistics {
  double rms = 0;    // distance of the share that is kept
  double kept = 1;   // share of the points, the closest ones
  double score = 0;  // rms / kept^2
};

// Keeps a share of the pairs, the closest ones, and puts them first: the share, of `least` at least, with the least
// score. This is the fractional root mean squared distance of Phillips, Liu and Tomasi, "Outlier robust ICP for
// minimizing fractional RMSD" (3DIM 2007). Their exponent is smaller; distances from a surface that are normally
// distributed keep 0.93 of the pairs with 2. Pairs that do not fit count as the farthest.
PairStatistics keep_closest(std::vector<ClosestPair>& pairs, double least);

// Pairs of points with the face. normals: of the points, unmoved; may be empty. height: of the points over the face.
std::vector<ClosestPair> pairs_with_face(std::span<const Vector3> points, std::span<const Vector3> normals,
                                         const Similarity& to_face, const SampledSurface& face, float height = 0);
// Pairs of the face's samples, of every `stride`th, with a surface that is moved.
std::vector<ClosestPair> pairs_with_other(const SampledSurface& other, const Similarity& to_face,
                                          const SampledSurface& face, std::size_t stride);

}  // namespace fb::tool
