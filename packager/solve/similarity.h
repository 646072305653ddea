// Rotation, one scale and translation.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"

namespace fb::tool {

// x -> scale * rotation * x + translation. The rotation is no mirror image.
struct Similarity {
  std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // row after row
  double scale = 1;
  std::array<double, 3> translation{};

  Vector3 operator()(Vector3 point) const;
  Vector3 turned(Vector3 direction) const;  // by the rotation alone
  Similarity inverse() const;
  // 3 x points, each moved.
  std::vector<float> applied(std::span<const float> points) const;
};

// The similarity that does `second` after `first`.
Similarity after(const Similarity& second, const Similarity& first);

// A pair of points that shall come together.
struct PointPair {
  Vector3 from, to;
  double weight = 1;
};

// The similarity with the least weighted sum of squared distances: B. K. P. Horn, "Closed-form solution of absolute
// orientation using unit quaternions", JOSA A 4 (1987): the rotation is the quaternion that is the eigenvector of the
// largest eigenvalue of a symmetric 4 x 4 matrix, the scale the ratio of the spreads, which favours neither side.
// scale: fixes it. Nothing with fewer than three pairs, or where the points of a side lie on one line or at one place.
std::optional<Similarity> align_pairs(std::span<const PointPair> pairs, std::optional<double> scale);

// A pair of a point and the tangent plane it shall lie on.
struct PlanePair {
  Vector3 from, to, normal;  // normal: unit, at `to`
  double weight = 1;
};

// A step towards the similarity with the least weighted sum of squared distances to the planes, to be done after the
// one that gave the points `from`: linear in small rotations (K.-L. Low, "Linear least-squares optimization for
// point-to-plane ICP surface registration", UNC 2004), with the logarithm of the scale as a seventh unknown unless
// fixed_scale. Unknowns that the planes do not determine stay 0.
Similarity plane_step(std::span<const PlanePair> pairs, bool fixed_scale);

}  // namespace fb::tool
