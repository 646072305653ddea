#include "model/detail_levels.h"

#include <algorithm>
#include <span>

#include "base/status.h"
#include "model/packed_model.h"

namespace fb {
namespace {

// What levels are checked against.
struct LevelContext {
  const PackedModel& model;
  std::vector<std::uint32_t> baked_index, part_of;  // by vertex
};

LevelContext context_of(const PackedModel& model) {
  LevelContext context{model, std::vector<std::uint32_t>(model.rest.vertex_count()), {}};
  for (std::uint32_t i = 0; i < context.baked_index.size(); ++i)
    context.baked_index[model.order.empty() ? i : model.order[i]] = i;
  const std::vector<std::uint32_t> ends = model.rest.part_ends();
  for (std::uint32_t part = 0; part < ends.size(); ++part) context.part_of.resize(ends[part], part);
  return context;
}

void check_vertices(const LevelContext& context, std::size_t k, const DetailLevel& level, std::uint32_t before) {
  if (level.vertices == 0 || level.vertices > before)
    fail(Status::bad_data, "level %zu has %u vertices, the one before it %u", k, level.vertices, before);
  const auto& blocks = context.model.row_blocks;
  const bool whole = std::any_of(blocks.begin(), blocks.end(), [&](const PackedRowBlock& block) {
    return std::size_t(block.first_row) + block.row_count == 3 * std::size_t(level.vertices);
  });
  if (!whole) fail(Status::bad_data, "level %zu: its %u vertices are no whole row blocks", k, level.vertices);
}

void check_level_polygons(const LevelContext& context, std::size_t k, const DetailLevel& level) {
  std::size_t corners = 0;
  for (const std::uint32_t size : level.polygon_sizes) {
    if (size < 3) fail(Status::bad_data, "level %zu has a polygon of %u corners", k, size);
    corners += size;
  }
  if (corners != level.polygon_corners.size())
    fail(Status::bad_data, "level %zu has %zu corners of polygons of %zu", k, level.polygon_corners.size(), corners);
  for (const std::uint32_t v : level.polygon_corners)
    if (v >= context.baked_index.size() || context.baked_index[v] >= level.vertices)
      fail(Status::bad_data, "level %zu has a polygon with vertex %u, which is none of its own", k, v);
  const std::size_t pairs = context.model.rest.uvs.size() / 2;
  if (level.uv_corners.size() != (pairs > 0 ? corners : 0))
    fail(Status::bad_data, "level %zu has %zu texture coordinates for %zu corners", k, level.uv_corners.size(),
         corners);
  for (const std::uint32_t uv : level.uv_corners)
    if (uv >= pairs) fail(Status::bad_data, "level %zu names texture coordinates %u of %zu", k, uv, pairs);
}

void check_level_parts(const LevelContext& context, std::size_t k, const DetailLevel& level) {
  if (level.parts.size() != context.model.rest.parts.size())
    fail(Status::bad_data, "level %zu has %zu meshes of %zu", k, level.parts.size(), context.model.rest.parts.size());
  std::size_t polygon = 0, corner = 0;
  for (std::size_t m = 0; m < level.parts.size(); ++m) {
    std::uint64_t in_runs = 0;
    for (const MaterialRun& run : level.parts[m].materials) {
      if (run.polygons == 0) fail(Status::bad_data, "level %zu, mesh %zu: a material without polygons", k, m);
      if (run.material != no_material && run.material >= context.model.character.materials.size())
        fail(Status::bad_data, "level %zu, mesh %zu: names material %u of %zu", k, m, run.material,
             context.model.character.materials.size());
      in_runs += run.polygons;
    }
    if (in_runs != level.parts[m].polygons)
      fail(Status::bad_data, "level %zu, mesh %zu: materials of %llu polygons for %u", k, m,
           static_cast<unsigned long long>(in_runs), level.parts[m].polygons);
    if (level.parts[m].polygons > level.polygon_sizes.size() - polygon)
      fail(Status::bad_data, "level %zu: its meshes have more polygons than its %zu", k, level.polygon_sizes.size());
    for (const std::size_t end = polygon + level.parts[m].polygons; polygon < end; ++polygon)
      for (const std::size_t last = corner + level.polygon_sizes[polygon]; corner < last; ++corner)
        if (context.part_of[level.polygon_corners[corner]] != m)
          fail(Status::bad_data, "level %zu: polygon %zu has vertex %u of another mesh", k, polygon,
               level.polygon_corners[corner]);
  }
  if (!level.parts.empty() && polygon != level.polygon_sizes.size())
    fail(Status::bad_data, "level %zu: its meshes have %zu of its %zu polygons", k, polygon,
         level.polygon_sizes.size());
}

void check_points(const LevelContext& context, std::size_t k, const DetailLevel& level, std::uint32_t before) {
  if (level.points.size() != before - level.vertices)
    fail(Status::bad_data, "level %zu has %zu points for %u vertices", k, level.points.size(), before - level.vertices);
  const std::vector<std::uint32_t> triangles = level.triangles();
  for (std::uint32_t i = 0; i < level.points.size(); ++i) {
    const auto& [triangle, weights] = level.points[i];
    const std::uint32_t baked = level.vertices + i;
    const std::uint32_t v = context.model.order.empty() ? baked : context.model.order[baked];
    if (triangle >= triangles.size() / 3 || weights[0] + weights[1] > 256)
      fail(Status::bad_data, "level %zu: vertex %u lies on triangle %u of %zu with weights %u and %u", k, v, triangle,
           triangles.size() / 3, weights[0], weights[1]);
    for (std::size_t corner = 0; corner < 3; ++corner)
      if (context.part_of[triangles[3 * std::size_t(triangle) + corner]] != context.part_of[v])
        fail(Status::bad_data, "level %zu: vertex %u lies on a triangle of another mesh", k, v);
  }
}

void check_coefficients(const PackedModel& model, std::size_t k) {
  const std::vector<std::uint8_t>& used = model.levels[k - 1].used_coefficients;
  if (used.size() != model.columns - model.direct.size())
    fail(Status::bad_data, "level %zu has %zu coefficients of %zu", k, used.size(),
         model.columns - model.direct.size());
  for (std::size_t c = 0; c < used.size(); ++c)
    if (used[c] > 1 || (k > 1 && used[c] > model.levels[k - 2].used_coefficients[c]))
      fail(Status::bad_data, "level %zu uses coefficient %zu, which the level before it does not", k,
           model.direct.size() + c);
}

}  // namespace

std::size_t coefficients_of(const PackedModel& model, const DetailLevel& level) {
  std::vector<std::uint8_t> used(model.columns, 0);
  for (const PackedRowBlock& block : model.row_blocks)
    for (const PackedColumn& column : block.columns)
      if (block.first_row < 3 * std::size_t(level.vertices))
        used[column.column] =
            column.column < model.direct.size() || level.used_coefficients[column.column - model.direct.size()];
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), std::uint8_t(1)));
}

void check_levels(const PackedModel& model) {
  if (model.levels.empty()) return;
  if (model.levels.size() > max_detail_levels)
    fail(Status::limit, "%zu levels of detail; at most %zu are supported", model.levels.size(), max_detail_levels);
  const LevelContext context = context_of(model);
  auto before = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  for (std::size_t k = 1; k <= model.levels.size(); ++k) {
    const DetailLevel& level = model.levels[k - 1];
    check_vertices(context, k, level, before);
    check_level_polygons(context, k, level);
    check_level_parts(context, k, level);
    check_points(context, k, level, before);
    check_coefficients(model, k);
    before = level.vertices;
  }
  for (const Socket& socket : model.character.sockets)
    for (const std::uint32_t v : socket.vertices)
      if (v < context.baked_index.size() && context.baked_index[v] >= before)
        fail(Status::bad_data, "socket \"%s\" has vertex %u, which not every level has", socket.name.c_str(), v);
}

}  // namespace fb
