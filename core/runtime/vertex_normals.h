// Normals of the posed mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "model/mesh.h"
#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {

// A vertex' normal is the sum of the area vectors of the polygons around it, made one long; null where there is no
// polygon, or no area. A polygon's area vector is that of the closed loop of its corners, flat or not: of a quad the
// cross product of its diagonals, of others the sum over the quads they fan into. Only what moved is computed: a
// chunk's vertices where its rows, or those of polygons around them, moved.
class VertexNormals {
 public:
  // Working memory: area vectors and normals, and which chunks' normals are not those at rest.
  class State {
   public:
    State(const VertexNormals& normals, std::pmr::memory_resource& memory);
    // The last pose's: 3 floats a vertex in baked order, and one float more.
    const float* normals() const { return normals_.data(); }
    // By chunk: whether its normals are not those at rest.
    std::span<const std::uint8_t> moved() const { return moved_; }

   private:
    friend class VertexNormals;
    std::pmr::vector<float> areas_, normals_;  // 4 floats a polygon, then 4 zeros; 3 a vertex and 1
    std::pmr::vector<std::uint8_t> moved_, needed_;
  };

  // place_of: the place of a vertex in baked order, empty if that is the mesh's own. chunk_rows: the first row of every
  // chunk, and then the number of rows.
  VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> place_of, std::span<const std::uint32_t> chunk_rows,
                std::pmr::memory_resource& memory);

  std::size_t chunk_count() const { return vertex_begin_.size() - 1; }
  // The vertices, in baked order, of a chunk: the first and the one behind the last.
  std::pair<std::uint32_t, std::uint32_t> vertices_of(std::size_t chunk) const {
    return {vertex_begin_[chunk], vertex_begin_[chunk + 1]};
  }
  // Of the rest mesh: 3 floats a vertex in baked order.
  std::span<const float> at_rest() const { return at_rest_; }

  // rows: positions in baked order, readable one float beyond. moved: whether a chunk's rows are not those at rest.
  void run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved, State& state) const;

 private:
  // Four corners, of which the last may repeat the first.
  struct Quad {
    std::uint32_t corner[4];
  };
  struct Larger {
    std::uint32_t polygon;
    Quad quad;
  };
  // The first polygons that have a vertex; where they are fewer, the number of polygons, whose area is null.
  struct Around {
    std::uint32_t polygon[4];
  };
  struct Beyond {
    std::uint32_t vertex, polygon;
  };
  void compute_areas(std::size_t chunk, const float* rows, float* areas) const;
  void compute_normals(const PoseKernels& kernels, std::size_t chunk, const float* areas, float* normals) const;

  std::pmr::vector<Quad> polygons_;  // chunk after chunk: that of a polygon's first corner; its first four corners
  std::pmr::vector<std::uint32_t> polygon_begin_;  // in polygons_, by chunk
  std::pmr::vector<Larger> larger_;                // the other quads of larger polygons' fans
  std::pmr::vector<std::uint32_t> larger_begin_;
  std::pmr::vector<Around> around_;               // of vertices
  std::pmr::vector<Beyond> beyond_;               // the other polygons that have a vertex, vertex after vertex
  std::pmr::vector<std::uint32_t> beyond_begin_;  // in beyond_, by chunk
  std::pmr::vector<std::uint32_t> vertex_begin_;  // vertices, in baked order, by the chunk their first row is in
  // The chunks whose polygons a chunk's normals are made of, and those whose rows these polygons are made of; which
  // chunks have polygons too large for that.
  std::pmr::vector<std::uint32_t> sources_, source_begin_, influences_, influence_begin_;
  std::pmr::vector<std::uint8_t> unpredictable_;
  std::pmr::vector<float> at_rest_;
};

}  // namespace fb::runtime
