#include "runtime/derivative/frame_derivatives.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

using Vector3d = SocketFrames::Vector3d;
using Matrix3 = SocketFrames::Matrix3;

Vector3d cross(const Vector3d& a, const Vector3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector3d& a, const Vector3d& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
// R v.
Vector3d turned(const Matrix3& r, const Vector3d& v) {
  return {dot(r[0], v), dot(r[1], v), dot(r[2], v)};
}
// R^T v.
Vector3d turned_back(const Matrix3& r, const Vector3d& v) {
  Vector3d result = {};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) result[b] += r[a][b] * v[a];
  return result;
}

Vector3d column(const Matrix3& m, std::size_t index) {
  return {m[0][index], m[1][index], m[2][index]};
}

// How the best rotation R of products M = sum of w q p^T = R P turns, before itself, as M changes: the w of
// (trace(P) - P) w = axis of R^T dM - (R^T dM)^T. 0 where no rotation is best. products: M^T.
Vector3d turn_of(const Matrix3& products, const Matrix3& rotation, const Matrix3& changes) {
  Matrix3 p, a;  // R^T M and R^T dM by columns, which are rows of the products
  for (std::size_t c = 0; c < 3; ++c) {
    p[c] = turned_back(rotation, products[c]);
    a[c] = turned_back(rotation, changes[c]);
  }
  const double trace = p[0][0] + p[1][1] + p[2][2];
  Matrix3 system;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) system[i][j] = (i == j ? trace : 0) - 0.5 * (p[i][j] + p[j][i]);
  // a[c][r] is element (r, c).
  const Vector3d axis = {a[1][2] - a[2][1], a[2][0] - a[0][2], a[0][1] - a[1][0]};
  const Vector3d first = column(system, 0), second = column(system, 1), third = column(system, 2);
  const double determinant = dot(first, cross(second, third));
  if (!(std::fabs(determinant) > 1e-12 * std::fabs(trace * trace * trace))) return {};
  return {dot(axis, cross(second, third)) / determinant, dot(first, cross(axis, third)) / determinant,
          dot(first, cross(second, axis)) / determinant};
}

}  // namespace

FrameDerivatives::FrameDerivatives(const EvaluationLayout& layout, std::span<const std::uint32_t> sockets,
                                   std::span<const std::uint32_t> joints, std::pmr::memory_resource& memory)
    : layout_(layout),
      sockets_(sockets.begin(), sockets.end(), &memory),
      joints_(joints.begin(), joints.end(), &memory),
      places_(&memory),
      fits_(sockets.size(), &memory),
      finite_(sockets.size(), &memory),
      frames_(frame_floats * count(), &memory),
      derivatives_(frames_.size() * layout.features.control_count(), &memory) {}

void FrameDerivatives::find_frames(std::span<const PointGroup> groups, const JointDerivatives& joints) {
  std::span<const PointPlace> places = places_;
  float* frame = frames_.data();
  for (std::size_t s = 0; s < sockets_.size(); ++s, frame += frame_floats) {
    const SocketFrames::Socket& socket = layout_.sockets.socket(sockets_[s]);
    const auto position = [&](std::size_t point) {
      const PointGroup& group = groups[places[point].group];
      const float* const first = group.positions() + places[point].slot;
      return std::array<float, 3>{first[0], first[group.stride()], first[2 * group.stride()]};
    };
    fits_[s] = layout_.sockets.fit(socket, position);
    finite_[s] = SocketFrames::write_frame(socket, fits_[s], frame);
    places = places.subspan(socket.end - socket.first);
  }
  for (const std::uint32_t joint : joints_) {
    const Frame<float>& rest = layout_.skin.joint(joint).rest;
    const Change<float> change = joints.change(joint);
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t c = 0; c < 4; ++c) {
        const float origin = c == 3 ? change[4 * row + 3] : 0;
        frame[4 * row + c] = rest[4 * row + c] + (times(&change[4 * row], rest, c) + origin);
      }
    frame += frame_floats;
  }
}

void FrameDerivatives::run_socket(std::size_t index, std::span<const PointPlace> places,
                                  std::span<const PointGroup> groups) {
  const SocketFrames::Socket& socket = layout_.sockets.socket(sockets_[index]);
  const auto points = layout_.sockets.points(socket);
  const SocketFrames::Fit& fit = fits_[index];
  for (std::size_t control = 0; control < layout_.features.control_count() && finite_[index]; ++control) {
    Vector3d centre = {};
    Matrix3 changes = {};
    bool moves = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const PointGroup& group = groups[places[i].group];
      const auto of = group.controls();
      const auto at = std::lower_bound(of.begin(), of.end(), static_cast<std::uint32_t>(control));
      if (at == of.end() || *at != control) continue;
      moves = true;
      const float* const rate = group.by_control(static_cast<std::size_t>(at - of.begin())) + places[i].slot;
      for (std::size_t b = 0; b < 3; ++b) {
        const double moved = points[i].weight * rate[b * group.stride()];
        centre[b] += moved;
        for (std::size_t a = 0; a < 3; ++a) changes[a][b] += points[i].position[a] * moved;
      }
    }
    if (!moves) continue;
    const Vector3d turn = turn_of(fit.products, fit.rotation, changes);
    float* const to = derivatives_.data() + control * frames_.size() + index * frame_floats;
    for (std::size_t c = 0; c < 4; ++c) {
      Vector3d axis = {socket.frame[c], socket.frame[4 + c], socket.frame[8 + c]};
      for (std::size_t a = 0; a < 3 && c == 3; ++a) axis[a] -= socket.centre[a];
      const Vector3d rate = turned(fit.rotation, cross(turn, axis));
      for (std::size_t a = 0; a < 3; ++a)
        to[4 * a + c] = static_cast<float>(c == 3 ? rate[a] + centre[a] / socket.weight : rate[a]);
    }
  }
}

void FrameDerivatives::run_joint(std::size_t index, const JointDerivatives& joints) {
  const std::uint32_t joint = joints_[index];
  const Frame<float>& rest = layout_.skin.joint(joint).rest;
  const auto controls = joints.controls(joint);
  for (std::size_t k = 0; k < controls.size(); ++k) {
    const Change<float>& rate = joints.derivative(joint, k);
    float* const to = derivatives_.data() + controls[k] * frames_.size() + (sockets_.size() + index) * frame_floats;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t c = 0; c < 4; ++c)
        to[4 * row + c] = times(&rate[4 * row], rest, c) + (c == 3 ? rate[4 * row + 3] : 0);
  }
}

void FrameDerivatives::run(std::span<const PointGroup> groups, const JointDerivatives& joints) {
  std::fill(derivatives_.begin(), derivatives_.end(), 0.0f);
  std::span<const PointPlace> places = places_;
  for (std::size_t s = 0; s < sockets_.size(); ++s) {
    const SocketFrames::Socket& socket = layout_.sockets.socket(sockets_[s]);
    run_socket(s, places, groups);
    places = places.subspan(socket.end - socket.first);
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) run_joint(j, joints);
}

}  // namespace fb::runtime
