#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/mesh.h"
#include "runtime/vertex_normals.h"

namespace fb::runtime {

// Vertex tangents of the posed mesh: the direction in which u grows. A vertex tangent is the sum, over the polygons
// around the vertex, of the integral of dP/du over the polygon's area in texture space, orthogonalised against the
// normal and normalised. By Green's theorem the integral equals that of P dv along the polygon's edges, planar or not:
// a sum of its corners with weights that do not depend on the pose. Null where there is no normal, no texture or no
// such direction.
class VertexTangents {
 public:
  // baked_index: by vertex, its index in baked order; empty if that is the order of the mesh. `heap`: of temporaries.
  // Without texture coordinates it takes no memory, and run() must not be called.
  VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::pmr::memory_resource& memory,
                 std::pmr::memory_resource& heap);

  // By vertex, in the order of the mesh: -1 where the texture is mirrored, else 1. The direction in which v grows is
  // about this times the cross product of normal and tangent. Empty without texture coordinates.
  std::span<const float> signs() const { return signs_; }

  // Arguments and results as of normals.run(), which has computed `normals` for these rows.
  void run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
           const VertexNormals& of_normals, const float* normals, PolygonGraph::State& state,
           const Spread& spread = {}) const;

 private:
  // A corner behind the first four of a polygon.
  struct ExtraCorner {
    std::uint32_t polygon, row;
    float weight;
  };

  std::pmr::vector<QuadWeights> weights_;  // by polygon; with that of the first corner, those of a polygon sum to 0
  std::pmr::vector<ExtraCorner> extra_corners_;
  PolygonSums sums_;
  std::pmr::vector<float> signs_;
};

}  // namespace fb::runtime
