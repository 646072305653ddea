// Driven joints in double precision, by formulas other than those of the runtime.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "test_models.h"

namespace fb {

// The rotation about a vector, by Rodrigues' formula.
inline Frame<double> rotation_about(const double (&v)[3]) {
  const double angle = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (angle == 0) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const double x = v[0] / angle, y = v[1] / angle, z = v[2] / angle, c = std::cos(angle), s = std::sin(angle);
  return {c + x * x * (1 - c),     x * y * (1 - c) - z * s, x * z * (1 - c) + y * s, 0,
          y * x * (1 - c) + z * s, c + y * y * (1 - c),     y * z * (1 - c) - x * s, 0,
          z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c),     0};
}

// Where joints are, from frames at rest that are inverted: frame of the parent x inverse rest of the parent x rest x
// what the joint does in its own axes.
template <class Number>
std::vector<Frame<double>> reference_frames(const Mesh& rest, const std::vector<Number>& points) {
  std::vector<Frame<double>> frames;
  std::size_t at = rest.first_joint_coordinate();
  const float* scale = rest.driven.scales.data();
  for (const DrivenJoint& joint : rest.driven.joints) {
    double n[numbers_a_joint] = {};
    const auto take = [&](std::uint32_t which, double* numbers) {
      for (std::size_t k = 0; k < numbers_a_joint; ++k)
        if (which >> k & 1) numbers[k] = double(*scale++) * points[at++];
    };
    take(joint.numbers, n);
    Frame<double> own = rotation_about({n[0], n[1], n[2]});
    for (const std::uint8_t which : joint.outer_rotations) {
      double outer[3] = {};
      take(which, outer);
      own = product(rotation_about(outer), own);
    }
    for (std::size_t row = 0; row < 3; ++row) {
      double* const r = &own[4 * row];
      r[3] = n[3 + row] + n[9 + row] - (r[0] * n[9] + r[1] * n[10] + r[2] * n[11]);  // the pivot stays in its place
      for (std::size_t column = 0; column < 3; ++column) r[column] *= 1 + n[6 + column];
    }
    const Frame<double> local = product(to_double(joint.rest), own);
    if (joint.parent == no_joint) {
      frames.push_back(local);
      continue;
    }
    const auto back = inverse(to_double(rest.driven.joints[joint.parent].rest));
    REQUIRE(back);
    frames.push_back(product(frames[joint.parent], product(*back, local)));
  }
  return frames;
}

// Positions by linear blend skinning.
template <class Number>
std::vector<double> reference_positions(const Mesh& rest, const std::vector<Number>& unskinned) {
  const std::vector<Frame<double>> frames = reference_frames(rest, unskinned);
  const Skin& skin = rest.driven.skin;
  std::vector<double> positions;
  for (std::size_t v = 0; v < rest.surface_vertex_count(); ++v) {
    const double p[3] = {unskinned[3 * v], unskinned[3 * v + 1], unskinned[3 * v + 2]};
    double moved[3] = {}, left = 1;
    for (std::size_t i = v * skin.influences; i < (v + 1) * skin.influences; ++i) {
      const auto bind = inverse(to_double(rest.driven.joints[skin.joints[i]].rest));
      REQUIRE(bind);
      const Frame<double> matrix = product(frames[skin.joints[i]], *bind);
      left -= skin.weights[i];
      for (std::size_t a = 0; a < 3; ++a) {
        const double* const row = &matrix[4 * a];
        moved[a] += skin.weights[i] * (row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]);
      }
    }
    for (std::size_t a = 0; a < 3; ++a) positions.push_back(moved[a] + left * p[a]);
  }
  return positions;
}

// Less than a full turn, where the polynomials hold.
inline PackedModel gentle_model() {
  PackedModel model = whole_model();
  for (std::size_t n = 6; n < 9; ++n) model.rest.driven.scales[n] /= 16;
  return model;
}

}  // namespace fb
