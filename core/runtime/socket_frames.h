#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/mesh_layout.h"

namespace fb::runtime {

// Frames that follow the posed surface: the best rigid fit of weighted vertices, by Horn's method (Closed-form solution
// of absolute orientation using unit quaternions, 1987) in a fixed number of steps. core/archive/EVALUATION.md defines
// every operation.
class SocketFrames {
 public:
  static constexpr std::size_t frame_floats = 12;

  // baked_index: see VertexWriter.
  SocketFrames(const PackedModel& model, std::span<const std::uint32_t> baked_index, std::pmr::memory_resource& memory);

  std::size_t count() const { return sockets_.size(); }
  // Writes frame_floats a socket, those of meshes that are not posed excepted. `rows`: posed vertices in baked order.
  void run(const float* rows, MeshMask meshes, float* frames) const;

  using Vector3d = std::array<double, 3>;
  using Matrix3 = std::array<Vector3d, 3>;
  struct Point {
    std::uint32_t index;  // of the vertex in baked order
    double weight;
    std::array<double, 3> position;  // at rest, from the centre
  };
  struct Socket {
    std::uint32_t first, end;  // of points_
    std::uint32_t mesh;
    double weight;                 // of all its points
    std::array<double, 3> centre;  // at rest
    std::array<float, frame_floats> frame;
  };
  const Socket& socket(std::size_t index) const { return sockets_[index]; }
  std::span<const Point> points(const Socket& socket) const {
    return std::span(points_).subspan(socket.first, socket.end - socket.first);
  }

  // The best rigid fit of a socket's vertices.
  struct Fit {
    Matrix3 products;  // [a][b]: the sum of weight x rest position a x posed position b, both from their centres
    Matrix3 rotation;
    Vector3d centre;  // posed
  };
  // position(i): where its point i is.
  template <class Position>
  Fit fit(const Socket& socket, const Position& position) const {
    const std::span<const Point> of = points(socket);
    Fit fit = {};
    for (std::size_t i = 0; i < of.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) fit.centre[a] += of[i].weight * position(i)[a];
    for (double& value : fit.centre) value /= socket.weight;
    for (std::size_t i = 0; i < of.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b)
          fit.products[a][b] += of[i].weight * of[i].position[a] * (position(i)[b] - fit.centre[b]);
    fit.rotation = best_rotation(fit.products);
    return fit;
  }
  // Writes the frame; false, and that at rest, where it is not finite.
  static bool write_frame(const Socket& socket, const Fit& fit, float* frame);

 private:
  static Matrix3 best_rotation(const Matrix3& products);

  std::pmr::vector<Point> points_;
  std::pmr::vector<Socket> sockets_;
};

}  // namespace fb::runtime
