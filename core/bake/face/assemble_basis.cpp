#include "bake/face/assemble_basis.h"

#include <algorithm>

#include "base/checked.h"

namespace fb::bake {
namespace {

// A column of the basis that moves some vertices: 3 values each.
struct SparseColumn {
  std::span<const std::uint32_t> vertices;
  std::span<const float> offsets;
  std::size_t next = 0;  // index of the first vertex not yet in a block
};

// Vertices of a row block: 63 rows, one less than the runtime's panels of 64 lanes.
constexpr std::size_t block_vertices = 21;

}  // namespace

Basis assemble_basis(std::size_t vertices, const SparseBlendshapes& base, std::span<const FaceRegion> regions,
                     std::span<const LocalBasis> bases) {
  std::vector<SparseColumn> columns;
  for (const SparseShape& shape : base.shapes) columns.push_back({shape.vertices, shape.offsets});
  for (std::size_t r = 0; r < regions.size(); ++r)
    for (std::size_t k = 0; k < bases[r].count; ++k)
      columns.push_back(
          {regions[r].vertices, std::span(bases[r].components).subspan(k * bases[r].rows, bases[r].rows)});

  Basis basis{checked_u32(3 * vertices, "coordinates"), checked_u32(columns.size(), "coefficients"), {}};
  for (std::size_t first = 0; first < vertices; first += block_vertices) {
    const std::size_t count = std::min(block_vertices, vertices - first);
    RowBlock group{static_cast<std::uint32_t>(3 * first), static_cast<std::uint32_t>(3 * count), {}, {}};
    for (std::size_t c = 0; c < columns.size(); ++c) {
      SparseColumn& column = columns[c];
      const std::size_t begin = column.next;
      while (column.next < column.vertices.size() && column.vertices[column.next] < first + count) ++column.next;
      if (column.next == begin) continue;
      group.columns.push_back(static_cast<std::uint32_t>(c));
      const std::size_t at = group.values.size();
      group.values.resize(at + group.row_count);
      for (std::size_t i = begin; i < column.next; ++i)
        std::copy_n(column.offsets.data() + 3 * i, 3, group.values.data() + at + 3 * (column.vertices[i] - first));
    }
    basis.row_blocks.push_back(std::move(group));
  }
  return basis;
}

}  // namespace fb::bake
