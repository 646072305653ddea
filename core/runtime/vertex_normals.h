#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "model/mesh.h"
#include "runtime/csr_table.h"
#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

// Vertex normals of the posed mesh. A vertex normal is the normalised sum of the area vectors of the polygons around
// the vertex; null where there is no polygon or no area. The area vector of a polygon is that of the closed loop of its
// corners, planar or not: for a quad the cross product of its diagonals, for others the sum over the quads of a fan.
// Only row blocks whose normals can change are computed: those with a vertex, or a polygon at one, in a moved row
// block.
class VertexNormals {
 public:
  // Working memory, and the normals of the last pose.
  class State {
   public:
    State(const VertexNormals& normals, std::pmr::memory_resource& memory);
    // Of the last pose: 3 floats a vertex in baked order, readable one float beyond.
    const float* normals() const { return normals_.data(); }
    // By row block: whether its normals can differ from those at rest.
    std::span<const std::uint8_t> moved() const { return moved_; }

   private:
    friend class VertexNormals;
    std::pmr::vector<float> areas_, normals_;  // 4 floats a polygon and a null vector; 3 a vertex and 1
    std::pmr::vector<std::uint8_t> moved_, needed_;
  };

  // baked_index: by vertex, its index in baked order; empty if that is the order of the mesh. block_rows: the first row
  // of every row block, then the number of rows. `heap`: of temporaries.
  VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::span<const std::uint32_t> block_rows,
                std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  std::size_t block_count() const { return vertex_offsets_.size() - 1; }
  // The vertices of a row block in baked order: first and one past the last.
  std::pair<std::uint32_t, std::uint32_t> vertices_of(std::size_t block) const {
    return {vertex_offsets_[block], vertex_offsets_[block + 1]};
  }
  // Of the rest mesh: 3 floats a vertex in baked order.
  std::span<const float> at_rest() const { return at_rest_; }

  // rows: positions in baked order, readable one float beyond. moved: by row block, whether its rows differ from rest.
  void run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved, State& state) const;

 private:
  struct Blocks;
  struct Polygon {
    std::uint32_t first_corner, size;
  };
  // Four corners; of a triangle the last repeats the first.
  struct Quad {
    std::uint32_t corner[4];
  };
  // A further quad of a polygon with more than four corners.
  struct FanQuad {
    std::uint32_t polygon;
    Quad quad;
  };
  // The first polygons at a vertex, padded with the number of polygons, whose area vector is null.
  struct FirstPolygons {
    std::uint32_t polygon[4];
  };
  // Any further polygon at a vertex.
  struct ExtraPolygon {
    std::uint32_t vertex, polygon;
  };

  static CsrTable<Polygon> polygons_by_block(const Mesh& mesh, std::span<const std::uint32_t> corners,
                                             const Blocks& blocks, std::size_t block_count,
                                             std::pmr::memory_resource& heap);
  void add_polygons(const CsrTable<Polygon>& polygons, std::span<const std::uint32_t> corners, const Blocks& blocks,
                    CsrBuilder<std::uint32_t>& at_vertex, std::pmr::memory_resource& heap);
  void add_incident_polygons(const CsrTable<std::uint32_t>& at_vertex);
  void compute_rest(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::pmr::memory_resource& heap);
  void compute_areas(std::size_t block, const float* rows, float* areas) const;
  void compute_normals(const PoseKernels& kernels, std::size_t block, const float* areas, float* normals) const;

  // Polygons by the row block of their first corner: the quads of their first four corners, and the rest of their fans.
  std::pmr::vector<Quad> polygons_;
  std::pmr::vector<std::uint32_t> polygon_offsets_;  // by row block
  std::pmr::vector<FanQuad> fan_quads_;
  std::pmr::vector<std::uint32_t> fan_offsets_;     // by row block
  std::pmr::vector<FirstPolygons> first_polygons_;  // by vertex
  std::pmr::vector<ExtraPolygon> extra_polygons_;
  std::pmr::vector<std::uint32_t> extra_offsets_;   // by row block
  std::pmr::vector<std::uint32_t> vertex_offsets_;  // by row block: vertices whose first row is in it
  CsrTable<std::uint32_t> polygon_blocks_;          // by row block: the row blocks with polygons at its vertices
  CsrTable<std::uint32_t> dependencies_;            // by row block: the row blocks with corners of those polygons
  std::pmr::vector<std::uint8_t> always_moved_;     // by row block: has a polygon too large to track its dependencies
  std::pmr::vector<float> at_rest_;
  float scale_;  // of distances whose products are computed; 1 for faces of an ordinary size
};

}  // namespace fb::runtime
