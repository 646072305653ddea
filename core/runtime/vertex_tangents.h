#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/mesh.h"
#include "runtime/csr_table.h"
#include "runtime/vertex_normals.h"

namespace fb::runtime {

// Vertex tangents of the posed mesh: the direction in which u grows. A vertex tangent is the sum, over the polygons
// around the vertex, of the integral of dP/du over the polygon's area in texture space, orthogonalised against the
// normal and normalised. By Green's theorem the integral equals that of P dv along the polygon's edges, planar or not:
// a sum of its corners with weights that do not depend on the pose. Null where there is no normal, no texture or no
// such direction.
class VertexTangents {
 public:
  // Working memory, and the tangents of the last pose.
  class State {
   public:
    State(const VertexTangents& tangents, std::pmr::memory_resource& memory);
    // Of the last pose: 3 floats a vertex in baked order, readable one float beyond.
    const float* tangents() const { return tangents_.data(); }

   private:
    friend class VertexTangents;
    std::pmr::vector<float> integrals_, tangents_;  // 3 floats a polygon; 3 a vertex
    std::pmr::vector<std::uint8_t> moved_;          // by row block: whether its tangents can differ from those at rest
  };

  // baked_index: by vertex, its index in baked order; empty if that is the order of the mesh. `normals`: of the same
  // mesh; `heap`: of temporaries. Without texture coordinates it takes no memory, and run() must not be called.
  VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> baked_index, const VertexNormals& normals,
                 std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  // By vertex, in the order of the mesh: -1 where the texture is mirrored, else 1. The direction in which v grows is
  // about this times the cross product of normal and tangent. Empty without texture coordinates.
  std::span<const float> signs() const { return signs_; }

  // rows: positions in baked order. normals_state: the result of normals.run() for these rows.
  void run(const float* rows, const VertexNormals& normals, const VertexNormals::State& normals_state,
           State& state) const;

 private:
  // A corner of a polygon; the weights of a polygon sum to 0.
  struct Corner {
    std::uint32_t vertex;  // in baked order
    float weight;
  };
  void compute_rest(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::span<const float> normals,
                    std::pmr::memory_resource& heap);
  void compute_integrals(const float* rows, float* integrals) const;
  void compute_tangents(std::uint32_t begin, std::uint32_t end, const float* integrals, const float* normals,
                        float* tangents) const;

  std::pmr::vector<Corner> corners_;                 // by polygon
  std::pmr::vector<std::uint32_t> polygon_offsets_;  // in corners_
  CsrTable<std::uint32_t> incident_;                 // by vertex in baked order: the polygons around it
  std::pmr::vector<float> signs_, at_rest_;
  std::size_t block_count_;
};

}  // namespace fb::runtime
