#include "export/skinned_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::array<float, 12> identity_frame = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

std::array<float, 12> moved_to(const float* origin, float sign) {
  std::array<float, 12> frame = identity_frame;
  for (std::size_t row = 0; row < 3; ++row) frame[4 * row + 3] = sign * origin[row];
  return frame;
}

}  // namespace

// What a vertex goes through: matrix * v + origin.
struct SkinnedMesh::Blend {
  std::array<double, 9> matrix = {};
  std::array<double, 3> origin = {};
};

SkinnedMesh::SkinnedMesh(facebaker::Decomposition decomposition, std::span<const float> rest)
    : decomposition_(std::move(decomposition)),
      info_(decomposition_.info()),
      rest_(rest),
      reach_(box_diagonal(rest)),
      names_{"root"} {
  for (std::size_t j = 0; j < joint_count(); ++j) names_.push_back(format("joint%02zu", j));
  for (std::size_t i = 0; i < std::size_t(info_.influences) * info_.vertex_count; ++i)
    joints_.push_back(static_cast<std::uint16_t>(info_.joints[i] + 1));
}

std::vector<float> SkinnedMesh::fit(std::span<const float> positions, double tolerance,
                                    const Parallel& parallel) const {
  std::vector<float> frames = decomposition_.fit(positions.data(), positions.size() / rest_.size(),
                                                 static_cast<std::uint32_t>(parallel.threads));
  for (std::size_t i = 0; i < frames.size(); i += 12) {
    const std::array<float, 12> rest = moved_to(info_.centres + 3 * (i / 12 % joint_count()), 1);
    double moved = 0;  // a bound of how far a vertex goes
    for (std::size_t k = 0; k < 12; ++k)
      moved += std::fabs(double(frames[i + k]) - double(rest[k])) * (k % 4 == 3 ? 1 : reach_);
    if (moved < tolerance) std::ranges::copy(rest, frames.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return frames;
}

SkinnedMesh::Blend SkinnedMesh::blend(std::span<const float> frames, std::size_t vertex) const {
  Blend sum;
  for (std::size_t k = 0; k < info_.influences; ++k) {
    const std::size_t place = info_.influences * vertex + k, joint = info_.joints[place];
    const double weight = double(info_.weights[place]);
    for (std::size_t row = 0; row < 3 && weight > 0; ++row) {
      const float* line = &frames[12 * joint + 4 * row];
      double origin = double(line[3]);
      for (std::size_t column = 0; column < 3; ++column) {
        sum.matrix[3 * row + column] += weight * double(line[column]);
        origin -= double(line[column]) * double(info_.centres[3 * joint + column]);
      }
      sum.origin[row] += weight * origin;
    }
  }
  return sum;
}

std::vector<float> SkinnedMesh::unskinned(std::span<const float> frames, std::span<const float> positions) const {
  std::vector<float> moves(rest_.size());
  for (std::size_t v = 0; v < rest_.size() / 3; ++v) {
    const Blend to = blend(frames, v);
    const auto& m = to.matrix;
    std::array<double, 3> p;
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = double(positions[3 * v + axis]) - to.origin[axis];
    // By the adjugate: blends of rotations that are far apart have none, and such a vertex is left alone.
    const std::array<double, 9> adjugate = {
        m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
        m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
        m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    const double determinant = m[0] * adjugate[0] + m[1] * adjugate[3] + m[2] * adjugate[6];
    if (!(determinant > 0.01)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* row = &adjugate[3 * axis];
      const double back = (row[0] * p[0] + row[1] * p[1] + row[2] * p[2]) / determinant;
      moves[3 * v + axis] = static_cast<float>(back - double(rest_[3 * v + axis]));
    }
  }
  return moves;
}

std::vector<float> SkinnedMesh::skinned(std::span<const float> frames, std::span<const float> moves) const {
  std::vector<float> points(rest_.size());
  for (std::size_t v = 0; v < rest_.size() / 3; ++v) {
    const Blend to = blend(frames, v);
    for (std::size_t row = 0; row < 3; ++row) {
      double sum = to.origin[row];
      for (std::size_t column = 0; column < 3; ++column)
        sum += to.matrix[3 * row + column] * (double(rest_[3 * v + column]) + double(moves[3 * v + column]));
      points[3 * v + row] = static_cast<float>(sum);
    }
  }
  return points;
}

CharacterView SkinnedMesh::character(const CharacterView& from) const {
  CharacterView made = from;
  made.joints.clear();
  for (std::size_t j = 0; j < names_.size(); ++j) {
    fb_joint joint;
    fb_joint_init(&joint);
    joint.name = names_[j].c_str();
    joint.parent = j == 0 ? FB_NO_JOINT : 0;
    const float* centre = j == 0 ? nullptr : info_.centres + 3 * (j - 1);
    std::ranges::copy(j == 0 ? identity_frame : moved_to(centre, 1), joint.rest);
    std::ranges::copy(j == 0 ? identity_frame : moved_to(centre, -1), joint.inverse_bind);
    made.joints.push_back(joint);
  }
  made.influences = info_.influences;
  made.skin_joints = joints_;
  made.skin_weights = {info_.weights, joints_.size()};
  return made;
}

std::vector<float> SkinnedMesh::with_root(std::span<const float> frames) const {
  std::vector<float> all;
  for (std::size_t first = 0; first < frames.size(); first += 12 * joint_count()) {
    all.insert(all.end(), identity_frame.begin(), identity_frame.end());
    all.insert(all.end(), frames.begin() + static_cast<std::ptrdiff_t>(first),
               frames.begin() + static_cast<std::ptrdiff_t>(first + 12 * joint_count()));
  }
  return all;
}

}  // namespace fb::tool
