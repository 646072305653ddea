#include "solve/closest_pairs.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

constexpr float least_cosine = 0.5f;  // of normals: 60 degrees

}  // namespace

PairStatistics keep_closest(std::vector<ClosestPair>& pairs, double least) {
  std::ranges::stable_sort(pairs, [](const ClosestPair& a, const ClosestPair& b) {
    return a.fits != b.fits ? a.fits : a.distance < b.distance;
  });
  PairStatistics best;
  best.score = INFINITY;
  double squares = 0;
  std::size_t kept = 0;
  const auto count = static_cast<double>(pairs.size());
  for (std::size_t i = 0; i < pairs.size() && pairs[i].fits; ++i) {
    squares += double(pairs[i].distance) * pairs[i].distance;
    const double share = static_cast<double>(i + 1) / count, rms = std::sqrt(squares / static_cast<double>(i + 1));
    const double score = rms / (share * share);
    if (share < least || score > best.score) continue;
    best = {rms, share, score};
    kept = i + 1;
  }
  pairs.resize(kept);
  return best;
}

std::vector<ClosestPair> pairs_with_face(std::span<const Vector3> points, std::span<const Vector3> normals,
                                         const Similarity& to_face, const SampledSurface& face, float height) {
  std::vector<ClosestPair> pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 from = to_face(points[i]);
    const auto found = face.tree.closest(from);
    if (!found) continue;
    const Vector3 normal = face.tree.normal(found->triangle);
    const bool aligned = normals.empty() || dot(to_face.turned(normals[i]), normal) >= least_cosine;
    const Vector3 to = found->position + normal * height;
    pairs.push_back({from, to, normal, aligned && !face.border.has(*found), length(from - to)});
  }
  return pairs;
}

std::vector<ClosestPair> pairs_with_other(const SampledSurface& other, const Similarity& to_face,
                                          const SampledSurface& face, std::size_t stride) {
  const Similarity back = to_face.inverse();
  std::vector<ClosestPair> pairs;
  for (std::size_t i = 0; i < face.samples.points.size(); i += stride) {
    const auto found = other.tree.closest(back(face.samples.points[i]));
    if (!found) continue;
    const Vector3 normal = face.samples.normals[i];
    const bool aligned = dot(to_face.turned(other.tree.normal(found->triangle)), normal) >= least_cosine;
    pairs.push_back({to_face(found->position), face.samples.points[i], normal, aligned && !other.border.has(*found),
                     static_cast<float>(found->distance * to_face.scale)});
  }
  return pairs;
}

}  // namespace fb::tool
