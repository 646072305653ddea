// What vertex normals and vertex tangents have in common: vectors of polygons are computed from positions, added up
// around vertices and made unit vectors, where row blocks have moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/mesh.h"
#include "runtime/csr_table.h"
#include "runtime/kernels/pose_kernels.h"
#include "runtime/spread.h"

namespace fb::runtime {

// The polygons around each vertex of the surface, in the order in which their vectors are added.
class PolygonSums {
 public:
  explicit PolygonSums(std::pmr::memory_resource& memory)
      : first_(&memory), further_(&memory), further_begin_(&memory) {}

  // at_vertex: by vertex, its polygons.
  void build(const CsrTable<std::uint32_t>& at_vertex);

  // Of the vertices of batches begin..end - 1, see PolygonGraph.
  PolygonsAround around(std::size_t begin, std::size_t end) const;

 private:
  std::uint32_t vertices_ = 0;
  std::pmr::vector<FirstPolygons> first_;
  std::pmr::vector<FurtherPolygons> further_;
  std::pmr::vector<std::uint32_t> further_begin_;
};

// Which vectors of polygons and of vertices change with the rows of which row blocks. Polygons are in chunks and
// vertices in batches, in the order of the mesh.
class PolygonGraph {
 public:
  static constexpr std::size_t chunk = 64, batch = 64;  // polygons; vertices

  // Working memory and the results of the last pose, of normals or of tangents, for graphs of up to so many vertices,
  // row blocks and polygons().
  struct State {
    State(std::size_t vertices, std::size_t blocks, std::size_t polygons, std::pmr::memory_resource& memory);
    std::pmr::vector<float> vectors;  // no_polygon_floats, then four floats a polygon
    std::pmr::vector<float> results;  // 3 floats a vertex of the surface, readable 25 floats beyond

   private:
    friend class PolygonGraph;
    const PolygonGraph* graph_ = nullptr;  // of the last pose
    std::pmr::vector<std::uint8_t> moved_, chunk_marks_, batch_marks_;
  };

  // baked_index: by vertex, its index in baked order; empty if that is the order of the mesh. block_rows: the first row
  // of every row block, then the number of rows.
  PolygonGraph(const Mesh& mesh, std::span<const std::uint32_t> baked_index, std::span<const std::uint32_t> block_rows,
               std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  // Polygons, and one more if they are odd.
  std::size_t polygons() const { return polygons_; }

  // Calls polygons(begin, end) for polygons and then vertices(begin, end) for batches of vertices that can differ from
  // those of the state's last pose. moved: by row block, whether its rows differ from rest.
  // Both may be called by several threads, for other ranges each.
  template <class Polygons, class Vertices>
  void run(std::span<const std::uint8_t> moved, State& state, const Spread& spread, const Polygons& polygons,
           const Vertices& vertices) const {
    find_changes(moved, state);
    for_runs(spread, {state.chunk_marks_.data(), chunk_count()}, [&](std::size_t begin, std::size_t end) {
      polygons(begin * chunk, end * chunk < polygons_ ? end * chunk : polygons_);
    });
    for_runs(spread, {state.batch_marks_.data(), batches_}, vertices);
  }

 private:
  void find_changes(std::span<const std::uint8_t> moved, State& state) const;
  template <class Visit>
  static void for_runs(const Spread& spread, std::span<const std::uint8_t> marks, const Visit& visit) {
    spread.run_ranges(marks.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t begin = first; begin < last; ++begin) {
        if (!marks[begin]) continue;
        std::size_t end = begin + 1;
        while (end < last && marks[end]) ++end;
        visit(begin, end);
        begin = end;
      }
    });
  }

  std::size_t chunk_count() const { return chunk_blocks_.row_offsets.size() - 1; }

  std::size_t polygons_, blocks_, batches_;
  CsrTable<std::uint32_t> chunk_blocks_;   // by chunk: the row blocks of its polygons' corners
  CsrTable<std::uint32_t> chunk_batches_;  // by chunk: the batches of its polygons' corners
};

}  // namespace fb::runtime
