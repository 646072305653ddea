#include "solve/fit_picture.h"

#include <algorithm>
#include <utility>

#include "base/length_units.h"
#include "base/status.h"
#include "render/camera.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/shading.h"

namespace fb::tool {
namespace {

constexpr float side_view = 50;  // degrees
constexpr Vector3 no_partner = {0.16f, 0.28f, 0.55f};

Camera camera_for(const MeshView& face, float yaw, const FitPictureOptions& options) {
  View view;
  view.yaw = yaw;
  const Resolution& r = options.resolution;
  return fit_camera(face.points, options.up_axis, view, static_cast<float>(r.width) / static_cast<float>(r.height));
}

// Colour maps have lengths for people: millimetres, where the unit is known.
ColourBar bar_up_to(double length, const ShownUnit& unit) {
  return {.scale = {.end = round_scale(static_cast<float>(length * unit.per_unit))}};
}

// A filled circle with a dark rim.
void draw_dot(Image& image, const Camera& camera, Vector3 point, Rgb colour) {
  constexpr int outer = 5, inner = 3;
  const auto [x, y] = camera.project(point);
  const int column = static_cast<int>(x * static_cast<float>(image.width)),
            row = static_cast<int>(y * static_cast<float>(image.height));
  for (int dy = -outer; dy <= outer; ++dy)
    for (int dx = -outer; dx <= outer; ++dx) {
      const int px = column + dx, py = row + dy, squared = dx * dx + dy * dy;
      if (squared > outer * outer || px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
      image.at(px, py) = squared > inner * inner ? Rgb{20, 22, 28} : colour;
    }
}

}  // namespace

Image draw_mesh_fit(const MeshView& face, const MeshView& other, const Similarity& to_face,
                    const MeshCorrespondence& correspondence, const FitPictureOptions& options) {
  const ShownUnit unit = shown_unit(options.unit);
  const ColourBar bar = bar_up_to(correspondence.statistics.p95, unit);
  std::vector<Vector3> colours(face.vertex_count(), no_partner);
  for (const Correspondence& c : correspondence.vertices)
    if (c.partner == Partner::found)
      colours[c.vertex] = map_colour(static_cast<float>(c.distance * unit.per_unit), bar.scale);
  const std::vector<std::uint32_t> face_triangles = face.triangles(), other_triangles = other.triangles();
  const std::vector<float> aligned = to_face.applied(other.points);
  std::vector<Panel> panels;
  for (const float yaw : {0.0f, side_view}) {
    const Camera camera = camera_for(face, yaw, options);
    panels.push_back({render({.triangles = face_triangles, .points = face.points, .colours = colours}, camera,
                             options.resolution, options.parallel),
                      format("face: distance, %s\nblue: no partner", unit.name.c_str()),
                      yaw != 0 ? std::optional(bar) : std::nullopt});
    panels.push_back(
        {render({.triangles = other_triangles, .points = aligned}, camera, options.resolution, options.parallel),
         "target, aligned",
         {}});
  }
  return make_montage(panels);
}

Image draw_marker_fit(const MeshView& face, const MarkerPlacement& placement, const FitPictureOptions& options,
                      const std::string& what) {
  const ShownUnit unit = shown_unit(options.unit);
  double most = 0;
  for (const PlacedMarker& marker : placement.markers) most = std::max(most, double(marker.distance));
  const ColourBar bar = bar_up_to(most, unit);
  const std::vector<std::uint32_t> triangles = face.triangles();
  std::vector<Panel> panels;
  for (const float yaw : {0.0f, side_view}) {
    const Camera camera = camera_for(face, yaw, options);
    Panel panel{render({.triangles = triangles, .points = face.points}, camera, options.resolution, options.parallel),
                format("%zu markers: %s, %s", placement.markers.size(), what.c_str(), unit.name.c_str()),
                yaw != 0 ? std::optional(bar) : std::nullopt};
    for (const PlacedMarker& marker : placement.markers)
      draw_dot(panel.image, camera, marker.point.at(face.points),
               to_srgb(map_colour(static_cast<float>(marker.distance * unit.per_unit), bar.scale)));
    panels.push_back(std::move(panel));
  }
  return make_montage(panels);
}

}  // namespace fb::tool
