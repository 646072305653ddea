#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/mesh.h"
#include "runtime/kernels/pose_kernels.h"
#include "runtime/polygon_graph.h"

namespace fb::runtime {

// Vertex normals of the posed mesh. A vertex normal is the normalised sum of the area vectors of the polygons around
// the vertex; null where there is no polygon or no area. The area vector of a polygon is that of the closed loop of its
// corners, planar or not: for a quad the cross product of its diagonals, for others the sum over the quads of a fan.
class VertexNormals {
 public:
  // baked_index: by vertex, its index in baked order; empty if that is the order of the mesh. block_rows: the first row
  // of every row block, then the number of rows; area vectors are added in the order of their polygons' row blocks.
  // `heap`: of temporaries.
  VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::span<const std::uint32_t> block_rows,
                std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  const PolygonGraph& graph() const { return graph_; }
  // The first four corners of every polygon.
  std::span<const Quad> quads() const { return quads_; }

  // rows: positions in baked order, readable one float beyond. moved: by row block, whether its rows differ from rest.
  // The results are those of the surface's vertices in the order of the mesh.
  void run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
           PolygonGraph::State& state, const Spread& spread = {}) const;

 private:
  // A further quad of a polygon with more than four corners.
  struct FanQuad {
    std::uint32_t polygon;
    Quad quad;
  };

  PolygonGraph graph_;
  std::pmr::vector<Quad> quads_;  // by polygon; padded to an even number with quads without area
  std::pmr::vector<FanQuad> fan_quads_;
  PolygonSums sums_;
  float scale_;  // of distances whose products are computed; 1 for faces of an ordinary size
};

}  // namespace fb::runtime
