#include "bake/analysis/jumping_curve.h"

#include <algorithm>

#include "bake/analysis/blendshape_parts.h"

namespace fb::bake {
namespace {

constexpr double coarse_curve = 5;  // tolerances that a curve of more than few_knots keeps to
constexpr std::size_t few_knots = 32, most_knots = 256;
constexpr std::size_t fitted_samples = 16;  // of a curve of few knots, besides those

// The knots and some samples between them.
CurveSamples thinned(const CurveSamples& from, const std::vector<double>& knots) {
  const std::size_t stride = std::max<std::size_t>(1, from.positions.size() / fitted_samples);
  CurveSamples some{from.control, {}, {}};
  for (std::size_t i = 0; i < from.positions.size(); ++i) {
    if (i % stride != 0 && !std::binary_search(knots.begin(), knots.end(), from.positions[i])) continue;
    some.positions.push_back(from.positions[i]);
    some.displacements.push_back(from.displacements[i]);
  }
  return some;
}

void add_shape(const Feature& feature, const std::vector<float>& offsets, double drop, SparseBlendshapes& part) {
  SparseShape shape = make_sparse(0, offsets, drop);
  if (shape.vertices.empty()) return;
  shape.feature = add_feature(part.features, feature);
  part.shapes.push_back(std::move(shape));
}

// A tent at every knot, from the knot before to the one after it.
void add_tents(const Control& control, const CurveSamples& samples, const std::vector<double>& knots, double drop,
               SparseBlendshapes& part) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const double knot = knots[k];
    const double below = k > 0 ? knots[k - 1] : 0, above = k + 1 < knots.size() ? knots[k + 1] : 0;
    const double inner = knot > 0 ? below : above, outer = knot > 0 ? above : below;  // 0, or on the other side: none
    const double left = inner * knot > 0 ? inner : 0, right = outer * knot > 0 ? outer : 2 * knot - left;
    const auto at = std::lower_bound(samples.positions.begin(), samples.positions.end(), knot);
    add_shape(tent(control, samples.control, left, knot, right),
              samples.displacements[static_cast<std::size_t>(at - samples.positions.begin())], drop, part);
  }
}

}  // namespace

ControlCurve fit_jumping_curve(const Control& control, const CurveSamples& samples, std::span<const Jump> jumps,
                               const CurveLimits& limits) {
  if (jumps.size() > most_jumps) return {};
  const CurveSamples continuous = without_jumps(samples, jumps);
  ControlCurve curve;
  std::vector<double> knots = polyline_knots(continuous, limits.tolerance);
  if (knots.size() <= limits.max_knots) {
    if (!continuous.positions.empty()) curve = fit_curve(control, thinned(continuous, knots), limits);
  } else {
    if (knots.size() > few_knots) knots = polyline_knots(continuous, coarse_curve * limits.tolerance);
    if (knots.size() > most_knots) return {};
    add_tents(control, continuous, knots, limits.drop, curve.part);
  }
  if (jumps.empty()) return curve;
  for (const Jump& jump : jumps) {
    curve.steps.push_back(step(control, samples.control, jump.inside, jump.outside));
    add_shape(curve.steps.back(), jump.offsets, limits.drop, curve.part);
  }
  curve.smooth = false;
  curve.knots = plateau_middles(control, jumps);
  return curve;
}

}  // namespace fb::bake
