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

 private:
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

  void run(const Socket& socket, const float* rows, float* frame) const;

  std::pmr::vector<Point> points_;
  std::pmr::vector<Socket> sockets_;
};

}  // namespace fb::runtime
