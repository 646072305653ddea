// A finer mesh of quads over another, for the same motion with more vertices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace rigs::dense {

using Quads = std::vector<std::array<std::uint32_t, 4>>;

// Every quad is cut into divisions x divisions. Each vertex is then averaged with the quads around it, as Catmull-Clark
// surfaces are, but for those of the border; with 1 division nothing changes. Posed vertices are fixed weighted sums of
// posed vertices of the coarse mesh, which come first and in their order.
class DenseMesh {
 public:
  DenseMesh(std::uint32_t coarse_vertices, const Quads& coarse, std::uint32_t divisions);

  const Quads& quads() const { return quads_; }
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(first_.size() - 1); }
  // Both are 3 floats a vertex. Thread-safe.
  void pose(const float* coarse, float* fine) const;

 private:
  Quads quads_;
  std::vector<std::uint32_t> first_;    // of each vertex in the following two; one more than vertices
  std::vector<std::uint32_t> corners_;  // of the coarse mesh
  std::vector<float> weights_;
};

}  // namespace rigs::dense
