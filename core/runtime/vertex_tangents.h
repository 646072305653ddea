// Tangents of the posed mesh, along its texture coordinates.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/mesh.h"
#include "runtime/vertex_normals.h"

namespace fb::runtime {

// A vertex' tangent is the direction in which u grows: the sum, over the polygons around it, of the integral of dP/du
// over each polygon's part of the picture, made perpendicular to the normal and one long. By Green's theorem that
// integral is the one of P dv along the polygon's edges, flat or not: a sum of its corners with weights that no pose
// changes. Null where there is no normal, no texture or no such direction.
class VertexTangents {
 public:
  // Working memory: tangents, and which chunks' are not those at rest.
  class State {
   public:
    State(const VertexTangents& tangents, std::pmr::memory_resource& memory);
    // The last pose's: 3 floats a vertex in baked order, and one float more.
    const float* tangents() const { return tangents_.data(); }

   private:
    friend class VertexTangents;
    std::pmr::vector<float> polygons_, tangents_;  // 3 floats each
    std::pmr::vector<std::uint8_t> moved_;
  };

  // place_of: the place of a vertex in baked order, empty if that is the mesh's own. `normals` are the mesh's. Without
  // texture coordinates it takes no memory, and may not run.
  VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> place_of, const VertexNormals& normals,
                 std::pmr::memory_resource& memory);

  // 1, or -1 where the picture lies mirrored on the polygons around a vertex, in the mesh's order: the direction in
  // which v grows is about this times the cross product of normal and tangent. Empty without texture coordinates.
  std::span<const float> signs() const { return signs_; }

  // rows: positions in baked order. normals: what was just run on them.
  void run(const float* rows, const VertexNormals& normals, const VertexNormals::State& normals_state,
           State& state) const;

 private:
  // A corner of a polygon and what it counts; those of a polygon sum to 0.
  struct Corner {
    std::uint32_t place;
    float weight;
  };
  void compute_polygons(const float* rows, float* polygons) const;
  void compute_tangents(std::uint32_t begin, std::uint32_t end, const float* polygons, const float* normals,
                        float* tangents) const;

  std::pmr::vector<Corner> corners_;                       // polygon after polygon
  std::pmr::vector<std::uint32_t> polygon_begin_;          // in corners_
  std::pmr::vector<std::uint32_t> around_, around_begin_;  // the polygons around each vertex, in baked order
  std::pmr::vector<float> signs_, at_rest_;
  std::size_t chunks_;
};

}  // namespace fb::runtime
