#include "render_surfaces.h"

#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <unordered_map>

namespace facebaker::engine {

void Axes::convert_direction(const float* direction, float* to) const {
  for (std::size_t i = 0; i < 3; ++i) to[i] = sign[i] * direction[from[i]];
}

void Axes::convert_position(const float* position, float* to) const {
  for (std::size_t i = 0; i < 3; ++i) to[i] = sign[i] * position[from[i]] * scale;
}

// P F P^-1 for the axes, s P t for the origin; P permutes axes and signs.
void Axes::convert_frame(const float* frame, float* to) const {
  for (std::size_t row = 0; row < 3; ++row) {
    const float* in = frame + 4 * from[row];
    for (std::size_t column = 0; column < 3; ++column)
      to[4 * row + column] = sign[row] * sign[column] * in[from[column]];
    to[4 * row + 3] = sign[row] * in[3] * scale;
  }
}

// With a' = s P a for positions a of the archive, a motion M a' + t of the engine is (P^-1 M P) a + P^-1 t / s of the
// archive; P permutes axes and signs.
void Axes::convert_motion_back(const float* frame, float* to) const {
  for (std::size_t row = 0; row < 3; ++row) {
    float* out = to + 4 * from[row];
    for (std::size_t column = 0; column < 3; ++column)
      out[from[column]] = sign[row] * sign[column] * frame[4 * row + column];
    out[3] = sign[row] * frame[4 * row + 3] / scale;
  }
}

float metres_per(const char* units) {
  const std::string_view text = units ? units : "";
  if (text == "mm") return 0.001f;
  if (text == "cm") return 0.01f;
  if (text == "dm") return 0.1f;
  if (text == "in") return 0.0254f;
  if (text == "ft") return 0.3048f;
  return 1;
}

namespace {

bool is_z(const char* up_axis) {
  return up_axis && std::string_view(up_axis) == "z";
}

fb_level level_at(const Model& model, std::uint32_t index) {
  fb_level level;
  fb_level_init(&level);
  check(fb_level_at(model.get(), index, &level));
  return level;
}

// Collects the vertices of a surface while corners of its polygons are added, level after level.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const Model& model, const Axes& axes)
      : axes_(axes), uvs_(fb_uvs(model.get())), signs_(fb_tangent_signs(model.get())) {}

  void add_polygon(RenderSurface& surface, const fb_level& level, std::uint32_t first_corner, std::uint32_t size,
                   std::vector<std::uint32_t>& indices) {
    const std::uint32_t first = vertex_of(surface, level, first_corner);
    std::uint32_t last = vertex_of(surface, level, first_corner + 1);
    for (std::uint32_t i = 2; i < size; ++i) {
      const std::uint32_t next = vertex_of(surface, level, first_corner + i);
      if (axes_.turn_triangles)
        indices.insert(indices.end(), {first, next, last});
      else
        indices.insert(indices.end(), {first, last, next});
      last = next;
    }
  }

 private:
  std::uint32_t vertex_of(RenderSurface& surface, const fb_level& level, std::uint32_t corner) {
    const std::uint32_t source = level.polygon_corners[corner], uv = level.uv_corners ? level.uv_corners[corner] : 0;
    const auto [known, fresh] = vertices_.emplace(static_cast<std::uint64_t>(source) << 32 | uv,
                                                  static_cast<std::uint32_t>(surface.sources.size()));
    if (!fresh) return known->second;
    surface.sources.push_back(source);
    if (level.uv_corners) {
      const float* pair = uvs_ + 2 * static_cast<std::size_t>(uv);
      surface.uvs.insert(surface.uvs.end(), {pair[0], axes_.v_down ? 1 - pair[1] : pair[1]});
      surface.tangent_signs.push_back(axes_.tangent_sign * signs_[source]);
    }
    return known->second;
  }

  const Axes& axes_;
  const float* uvs_;
  const float* signs_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
};

// Where each vertex of the source's order is in baked order.
std::vector<std::uint32_t> baked_places(const Model& model) {
  const std::uint32_t* order = fb_vertex_order(model.get());
  std::vector<std::uint32_t> places(model.vertex_count());
  for (std::uint32_t v = 0; v < places.size(); ++v) places[order ? order[v] : v] = v;
  return places;
}

std::vector<RenderSurface> empty_surfaces(const fb_level& whole, std::uint32_t meshes, std::uint32_t levels) {
  std::vector<RenderSurface> surfaces;
  for (std::uint32_t m = 0; m < meshes; ++m)
    for (std::uint32_t r = 0; r < whole.meshes[m].run_count; ++r) {
      RenderSurface& surface = surfaces.emplace_back();
      surface.mesh = m;
      surface.material = whole.meshes[m].runs[r].material;
      surface.levels.resize(levels);
    }
  return surfaces;
}

// The surface that a run of polygons belongs to: the next one of its mesh and material from `from` on, or else the
// first; the number of surfaces if there is none.
std::size_t surface_of(const std::vector<RenderSurface>& surfaces, std::uint32_t mesh, std::uint32_t material,
                       std::size_t from) {
  const auto has = [&](const RenderSurface& surface) { return surface.mesh == mesh && surface.material == material; };
  const auto begin = surfaces.begin(), end = surfaces.end();
  const auto next = std::find_if(begin + static_cast<std::ptrdiff_t>(from), end, has);
  return static_cast<std::size_t>((next != end ? next : std::find_if(begin, end, has)) - begin);
}

void add_level(const fb_level& level, std::uint32_t index, std::uint32_t meshes, std::vector<RenderSurface>& surfaces,
               std::vector<SurfaceBuilder>& builders) {
  std::size_t next = 0;
  for (std::uint32_t m = 0; m < meshes; ++m) {
    const fb_mesh& mesh = level.meshes[m];
    std::uint32_t polygon = mesh.first_polygon, corner = mesh.first_corner;
    for (std::uint32_t r = 0; r < mesh.run_count; ++r) {
      const std::size_t s = surface_of(surfaces, m, mesh.runs[r].material, next);
      const std::uint32_t end = polygon + mesh.runs[r].polygon_count;
      for (; polygon < end; corner += level.polygon_sizes[polygon++])
        if (s < surfaces.size())
          builders[s].add_polygon(surfaces[s], level, corner, level.polygon_sizes[polygon],
                                  surfaces[s].levels[index].indices);
      if (s < surfaces.size()) next = s + 1;
    }
  }
  for (RenderSurface& surface : surfaces)
    surface.levels[index].vertex_count = static_cast<std::uint32_t>(surface.sources.size());
}

}  // namespace

Axes axes_of_godot(const char* up_axis, const char* units, bool metres) {
  Axes axes;
  if (is_z(up_axis)) axes.from = {0, 2, 1}, axes.sign = {1, 1, -1};
  if (metres) axes.scale = metres_per(units);
  axes.turn_triangles = axes.v_down = true;
  return axes;
}

Axes axes_of_unreal(const char* up_axis, const char* units) {
  Axes axes;
  if (is_z(up_axis))
    axes.sign = {1, -1, 1};
  else
    axes.from = {0, 2, 1};
  axes.scale = 100 * metres_per(units);
  // Of a left-handed engine, triangles stay: their normal is the cross product of the second edge and the first there.
  // The mirrored cross product and v turned round cancel out in the sign of tangents.
  axes.v_down = true;
  return axes;
}

std::vector<RenderSurface> render_surfaces(const Model& model, const Axes& axes) {
  const std::uint32_t meshes = fb_mesh_count(model.get()), levels = fb_level_count(model.get());
  std::vector<RenderSurface> surfaces = empty_surfaces(level_at(model, 0), meshes, levels);
  std::vector<SurfaceBuilder> builders(surfaces.size(), SurfaceBuilder(model, axes));
  for (std::uint32_t index = levels; index-- > 0;) add_level(level_at(model, index), index, meshes, surfaces, builders);
  const std::vector<std::uint32_t> places = baked_places(model);
  for (RenderSurface& surface : surfaces)
    for (const std::uint32_t source : surface.sources) surface.baked.push_back(places[source]);
  return surfaces;
}

}  // namespace facebaker::engine
