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

Portrait::Difference Portrait::draw_beside(std::span<const float> truth, std::span<const float> predicted,
                                           float full_scale) const {
  Difference difference;
  std::vector<float> distances(truth.size() / 3);
  double squares = 0;
  for (std::size_t v = 0; v < distances.size(); ++v) {
    const double distance = length(vector_at(predicted.data(), v) - vector_at(truth.data(), v)) / diagonal_;
    distances[v] = static_cast<float>(distance);
    squares += distance * distance;
    difference.max = std::max(difference.max, distance);
  }
  difference.rms = std::sqrt(squares / distances.size());
  const float full = full_scale > 0 ? full_scale : round_scale(static_cast<float>(difference.max));
  const Scene errors = {.triangles = triangles_, .points = predicted, .scalars = distances, .scalar_full = full};
  difference.image = compose({{draw(truth), "true rig", {}},
                              {draw(predicted), "archive", {}},
                              {render(errors, camera_, canvas_, parallel_),
                               format("error / diagonal: rms %.1e, max %.1e", difference.rms, difference.max), full}});
  return difference;
}

}  // namespace fb
