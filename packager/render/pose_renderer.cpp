#include "render/pose_renderer.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/montage.h"

namespace fb::tool {

PoseRenderer::PoseRenderer(const MeshView& rest, const std::string& up_axis, View view, const Resolution& resolution,
                           const Parallel& parallel)
    : triangles_(rest.triangles()), diagonal_(rest.diagonal()), resolution_(resolution), parallel_(parallel) {
  view.margin = 0.09f;
  camera_ = fit_camera(rest.points, up_axis, view, static_cast<float>(resolution.width) / resolution.height);
}

Image PoseRenderer::draw(std::span<const float> points) const {
  return render({.triangles = triangles_, .points = points}, camera_, resolution_, parallel_);
}

Image PoseRenderer::draw_scalars(std::span<const float> points, std::span<const float> scalars, float scale_max) const {
  return render({.triangles = triangles_, .points = points, .scalars = scalars, .scale_max = scale_max}, camera_,
                resolution_, parallel_);
}

PoseRenderer::Comparison PoseRenderer::draw_comparison(const Pose& reference, const std::vector<Pose>& faces,
                                                       float scale_max) const {
  Comparison comparison;
  std::vector<Panel> panels = {{draw(reference.points), reference.caption, {}}};
  std::vector<std::vector<float>> distances;
  double max = 0;
  for (const Pose& face : faces) {
    Difference difference;
    std::vector<float>& of_face = distances.emplace_back(reference.points.size() / 3);
    double squares = 0;
    for (std::size_t v = 0; v < of_face.size(); ++v) {
      const double distance =
          length(vector_at(face.points.data(), v) - vector_at(reference.points.data(), v)) / diagonal_;
      of_face[v] = static_cast<float>(distance);
      squares += distance * distance;
      difference.max = std::max(difference.max, distance);
    }
    difference.rms = std::sqrt(squares / static_cast<double>(of_face.size()));
    max = std::max(max, difference.max);
    comparison.differences.push_back(difference);
    panels.push_back({draw(face.points), face.caption, {}});
  }
  if (!(scale_max > 0)) scale_max = round_scale(static_cast<float>(max));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string title = faces.size() > 1 ? faces[f].caption + " error" : "error / diagonal";
    const Difference& difference = comparison.differences[f];
    panels.push_back({draw_scalars(faces[f].points, distances[f], scale_max),
                      format("%s\nrms %.1e, max %.1e", title.c_str(), difference.rms, difference.max),
                      f + 1 == faces.size() ? std::optional(scale_max) : std::nullopt});
  }
  comparison.image = make_montage(panels);
  return comparison;
}

}  // namespace fb::tool
