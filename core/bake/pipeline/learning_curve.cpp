#include "bake/pipeline/learning_curve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/sampling/pose_generators.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t fitted_points = 3;
constexpr double flat = 0.05;  // below this exponent twice the poses gain less than 4 %

void fit(LearningCurve& curve) {
  std::vector<std::pair<double, double>> logs;
  const std::size_t skipped = curve.points.size() - std::min(curve.points.size(), fitted_points);
  for (std::size_t i = skipped; i < curve.points.size(); ++i) {
    const LearningCurve::Point& point = curve.points[i];
    if (!(point.errors.mse > 0)) return;  // exact: there is nothing to extrapolate
    logs.emplace_back(std::log(static_cast<double>(point.poses)), std::log(point.errors.mse));
  }
  const double count = static_cast<double>(logs.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, squares = 0;
  for (const auto& [x, y] : logs) {
    mean_x += x / count;
    mean_y += y / count;
  }
  for (const auto& [x, y] : logs) {
    xx += (x - mean_x) * (x - mean_x);
    xy += (x - mean_x) * (y - mean_y);
  }
  curve.exponent = -xy / xx;
  curve.factor = std::exp(mean_y + curve.exponent * mean_x);
  for (const auto& [x, y] : logs) squares += std::pow(y - mean_y + curve.exponent * (x - mean_x), 2) / count;
  curve.deviation = std::exp(std::sqrt(squares)) - 1;
}

}  // namespace

double LearningCurve::mse_at(double poses) const {
  return factor * std::pow(poses, -exponent);
}

LearningCurve learning_curve(std::size_t poses, std::uint64_t seed, const TrainAndMeasure& train_and_measure,
                             Progress& progress) {
  if (poses < 16) fail(Status::invalid_argument, "a learning curve needs 16 poses, not %zu", poses);
  std::vector<std::uint32_t> order(poses);
  std::iota(order.begin(), order.end(), 0u);
  Random random = open_stream(seed, Stream::learning_curve, 0);
  for (std::size_t i = 0; i + 1 < poses; ++i)
    std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(poses - i))]);
  LearningCurve curve;
  for (const std::size_t part : {8, 4, 2, 1}) {
    const std::size_t count = poses / part;
    progress.note(format("learning curve: training on %zu of %zu poses", count, poses));
    std::vector<std::uint32_t> some(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
    std::sort(some.begin(), some.end());
    curve.points.push_back({count, train_and_measure(some)});
    if (!std::isfinite(curve.points.back().errors.mse))
      fail(Status::not_finite, "learning curve: the error on %zu poses is not finite", count);
  }
  fit(curve);
  return curve;
}

std::string learning_curve_text(const LearningCurve& curve) {
  std::string text = "     poses        mse        max        mfm\n";
  for (const LearningCurve::Point& point : curve.points)
    text += format("%10zu  %9.2e  %9.2e  %9.2e\n", point.poses, point.errors.mse, point.errors.max, point.errors.mfm);
  const double most = static_cast<double>(curve.points.back().poses);
  if (curve.factor == 0) return text + "nothing is left to learn\n";
  if (curve.exponent < flat)
    return text + format("more poses would not lower the error much: it falls as poses^%.2f\n", -curve.exponent);
  return text +
         format("twice the poses would give an mse of about %.1e: it falls as poses^%.2f, give or take %.0f %%\n",
                curve.mse_at(2 * most), -curve.exponent, 100 * curve.deviation);
}

}  // namespace fb::bake
