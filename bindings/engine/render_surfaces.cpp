#include "render_surfaces.h"

#include <facebaker/facebaker_character.h>

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

// Collects the vertices of a run while its corners are added.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const Model& model, const Axes& axes, RenderSurface& surface)
      : axes_(axes),
        surface_(surface),
        corners_(fb_polygon_corners(model.get())),
        uvs_(fb_uvs(model.get())),
        uv_corners_(fb_uv_corners(model.get())),
        signs_(fb_tangent_signs(model.get())) {}

  void add_polygon(std::uint32_t first_corner, std::uint32_t size) {
    const std::uint32_t first = vertex_of(first_corner);
    std::uint32_t last = vertex_of(first_corner + 1);
    for (std::uint32_t i = 2; i < size; ++i) {
      const std::uint32_t next = vertex_of(first_corner + i);
      if (axes_.turn_triangles)
        surface_.indices.insert(surface_.indices.end(), {first, next, last});
      else
        surface_.indices.insert(surface_.indices.end(), {first, last, next});
      last = next;
    }
  }

 private:
  std::uint32_t vertex_of(std::uint32_t corner) {
    const std::uint32_t source = corners_[corner], uv = uv_corners_ ? uv_corners_[corner] : 0;
    const auto [known, fresh] = vertices_.emplace(static_cast<std::uint64_t>(source) << 32 | uv,
                                                  static_cast<std::uint32_t>(surface_.sources.size()));
    if (!fresh) return known->second;
    surface_.sources.push_back(source);
    if (uv_corners_) {
      const float* pair = uvs_ + 2 * static_cast<std::size_t>(uv);
      surface_.uvs.insert(surface_.uvs.end(), {pair[0], axes_.v_down ? 1 - pair[1] : pair[1]});
      surface_.tangent_signs.push_back(axes_.tangent_sign * signs_[source]);
    }
    return known->second;
  }

  const Axes& axes_;
  RenderSurface& surface_;
  const std::uint32_t* corners_;
  const float* uvs_;
  const std::uint32_t* uv_corners_;
  const float* signs_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
};

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
  std::vector<RenderSurface> surfaces;
  const std::uint32_t* sizes = fb_polygon_sizes(model.get());
  for (std::uint32_t m = 0; m < fb_mesh_count(model.get()); ++m) {
    fb_mesh mesh;
    fb_mesh_init(&mesh);
    check(fb_mesh_at(model.get(), m, &mesh));
    std::uint32_t polygon = mesh.first_polygon, corner = mesh.first_corner;
    for (std::uint32_t r = 0; r < mesh.run_count; ++r) {
      RenderSurface& surface = surfaces.emplace_back();
      surface.mesh = m;
      surface.material = mesh.runs[r].material;
      SurfaceBuilder builder(model, axes, surface);
      for (std::uint32_t end = polygon + mesh.runs[r].polygon_count; polygon < end; corner += sizes[polygon++])
        builder.add_polygon(corner, sizes[polygon]);
    }
  }
  return surfaces;
}

}  // namespace facebaker::engine
