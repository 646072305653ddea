#include "runtime/socket_frames.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

using Vector3d = SocketFrames::Vector3d;
using Matrix3 = SocketFrames::Matrix3;
using Matrix4 = std::array<std::array<double, 4>, 4>;

constexpr int squarings = 24;  // enough for vertices that lie within a band 500 times as long as it is wide
constexpr Matrix3 identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

// Horn's symmetric matrix, whose eigenvector of the largest eigenvalue is the quaternion of the best rotation, plus
// twice the norm of `s` on its diagonal, so that no eigenvalue is negative. s[a][b]: sum of weight * rest[a] *
// posed[b].
Matrix4 shifted_horn_matrix(const Matrix3& s) {
  double squares = 0;
  for (const Vector3d& row : s)
    for (const double value : row) squares += value * value;
  const double shift = 2 * std::sqrt(squares);
  const double xx = s[0][0], yy = s[1][1], zz = s[2][2];
  const double yz = s[1][2] - s[2][1], zx = s[2][0] - s[0][2], xy = s[0][1] - s[1][0];
  const double yz2 = s[1][2] + s[2][1], zx2 = s[2][0] + s[0][2], xy2 = s[0][1] + s[1][0];
  return {{{xx + yy + zz + shift, yz, zx, xy},
           {yz, xx - yy - zz + shift, xy2, zx2},
           {zx, xy2, yy - xx - zz + shift, yz2},
           {xy, zx2, yz2, zz - xx - yy + shift}}};
}

double trace(const Matrix4& m) {
  return m[0][0] + m[1][1] + m[2][2] + m[3][3];
}

Matrix4 squared(const Matrix4& m) {
  Matrix4 result;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      result[i][j] = m[i][0] * m[0][j] + m[i][1] * m[1][j] + m[i][2] * m[2][j] + m[i][3] * m[3][j];
  return result;
}

Matrix3 rotation_of(const std::array<double, 4>& quaternion) {
  const auto [w, x, y, z] = quaternion;
  return {{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}}};
}

Vector3d rotated(const Matrix3& r, const Vector3d& v) {
  Vector3d result;
  for (std::size_t a = 0; a < 3; ++a) result[a] = r[a][0] * v[0] + r[a][1] * v[1] + r[a][2] * v[2];
  return result;
}

}  // namespace

// Squaring a matrix often leaves its largest eigenvalue alone: every column is then the eigenvector.
SocketFrames::Matrix3 SocketFrames::best_rotation(const Matrix3& s) {
  Matrix4 m = shifted_horn_matrix(s);
  for (int step = 0; step <= squarings; ++step) {
    const double scale = trace(m);
    if (!(scale > 0)) return identity;
    for (auto& row : m)
      for (double& value : row) value /= scale;
    if (step < squarings) m = squared(m);
  }
  std::size_t column = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (m[i][i] > m[column][column]) column = i;
  std::array<double, 4> quaternion = m[column];
  double squares = 0;
  for (const double value : quaternion) squares += value * value;
  const double length = std::sqrt(squares);
  for (double& value : quaternion) value /= length;
  return rotation_of(quaternion);
}

SocketFrames::SocketFrames(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                           std::pmr::memory_resource& memory)
    : points_(&memory), sockets_(&memory) {
  const std::vector<fb::Socket>& sockets = model.character.sockets;
  std::size_t points = 0;
  for (const fb::Socket& socket : sockets) points += socket.vertices.size();
  points_.reserve(points);
  sockets_.reserve(sockets.size());
  for (const fb::Socket& from : sockets) {
    Socket socket = {static_cast<std::uint32_t>(points_.size()), 0, 0, 0, {}, from.frame};
    for (std::uint32_t end = 0; socket.mesh < model.rest.parts.size(); ++socket.mesh)
      if (from.vertices[0] < (end += model.rest.parts[socket.mesh].vertices)) break;
    for (std::size_t i = 0; i < from.vertices.size(); ++i) {
      const std::uint32_t vertex = from.vertices[i];
      Point& point =
          points_.emplace_back(Point{baked_index.empty() ? vertex : baked_index[vertex], from.weights[i], {}});
      for (std::size_t a = 0; a < 3; ++a) {
        point.position[a] = model.rest.points[3 * std::size_t(vertex) + a];
        socket.centre[a] += point.weight * point.position[a];
      }
      socket.weight += point.weight;
    }
    socket.end = static_cast<std::uint32_t>(points_.size());
    for (double& value : socket.centre) value /= socket.weight;
    for (std::uint32_t i = socket.first; i < socket.end; ++i)
      for (std::size_t a = 0; a < 3; ++a) points_[i].position[a] -= socket.centre[a];
    sockets_.push_back(socket);
  }
}

bool SocketFrames::write_frame(const Socket& socket, const Fit& fit, float* frame) {
  const std::array<float, frame_floats>& rest = socket.frame;
  std::array<float, frame_floats> posed;
  for (std::size_t column = 0; column < 4; ++column) {
    Vector3d axis = {rest[column], rest[4 + column], rest[8 + column]};
    if (column == 3)
      for (std::size_t a = 0; a < 3; ++a) axis[a] -= socket.centre[a];
    axis = rotated(fit.rotation, axis);
    for (std::size_t a = 0; a < 3; ++a)
      posed[4 * a + column] = static_cast<float>(column == 3 ? axis[a] + fit.centre[a] : axis[a]);
  }
  const bool finite = std::all_of(posed.begin(), posed.end(), [](float value) { return std::isfinite(value); });
  std::copy_n(finite ? posed.data() : rest.data(), frame_floats, frame);
  return finite;
}

void SocketFrames::run(const float* rows, MeshMask meshes, float* frames) const {
  for (std::size_t i = 0; i < sockets_.size(); ++i) {
    if (!meshes.empty() && !meshes[sockets_[i].mesh]) continue;
    const Point* const first = points(sockets_[i]).data();
    const auto position = [&](std::size_t point) { return rows + 3 * std::size_t(first[point].index); };
    write_frame(sockets_[i], fit(sockets_[i], position), frames + i * frame_floats);
  }
}

}  // namespace fb::runtime
