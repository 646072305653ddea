#include "render/portrait.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/panels.h"

namespace fb {

Portrait::Portrait(const Mesh& rest, const std::string& up_axis, View view, const Canvas& canvas,
                   const Parallel& parallel)
    : triangles_(rest.triangles()), diagonal_(rest.diagonal()), canvas_(canvas), parallel_(parallel) {
  view.margin = 0.09f;
  camera_ = frame(rest.points, up_axis, view, static_cast<float>(canvas.width) / canvas.height);
}

Image Portrait::draw(std::span<const float> points) const {
  return render({.triangles = triangles_, .points = points}, camera_, canvas_, parallel_);
}

Image Portrait::draw_field(std::span<const float> points, std::span<const float> field, float full) const {
  return render({.triangles = triangles_, .points = points, .scalars = field, .scalar_full = full}, camera_, canvas_,
                parallel_);
}

Portrait::Comparison Portrait::draw_beside(const Posed& truth, const std::vector<Posed>& faces,
                                           float full_scale) const {
  Comparison comparison;
  std::vector<Panel> panels = {{draw(truth.points), truth.caption, {}}};
  std::vector<std::vector<float>> distances;
  double max = 0;
  for (const Posed& face : faces) {
    Difference difference;
    std::vector<float>& far = distances.emplace_back(truth.points.size() / 3);
    double squares = 0;
    for (std::size_t v = 0; v < far.size(); ++v) {
      const double distance = length(vector_at(face.points.data(), v) - vector_at(truth.points.data(), v)) / diagonal_;
      far[v] = static_cast<float>(distance);
      squares += distance * distance;
      difference.max = std::max(difference.max, distance);
    }
    difference.rms = std::sqrt(squares / static_cast<double>(far.size()));
    max = std::max(max, difference.max);
    comparison.differences.push_back(difference);
    panels.push_back({draw(face.points), face.caption, {}});
  }
  const float full = full_scale > 0 ? full_scale : round_scale(static_cast<float>(max));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string who = faces.size() > 1 ? faces[f].caption + " error" : "error / diagonal";
    panels.push_back(
        {draw_field(faces[f].points, distances[f], full),
         format("%s\nrms %.1e, max %.1e", who.c_str(), comparison.differences[f].rms, comparison.differences[f].max),
         f + 1 == faces.size() ? std::optional(full) : std::nullopt});
  }
  comparison.image = compose(panels);
  return comparison;
}

}  // namespace fb
