#include "bake/pipeline/learning_curve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/measure/evaluate.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/recipe/work_folder.h"
#include "bake/sampling/coverage.h"
#include "base/output_lock.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t fewest_poses = 16, fitted_points = 3, curve_poses = 1000;
constexpr double flat = 0.05;  // exponent below which twice the poses lower the error by less than 4 %

void fit_power_law(LearningCurve& curve) {
  std::vector<std::pair<double, double>> logs;
  const std::size_t skipped = curve.points.size() - std::min(curve.points.size(), fitted_points);
  for (std::size_t i = skipped; i < curve.points.size(); ++i) {
    const LearningCurve::Point& point = curve.points[i];
    if (!(point.errors.mse > 0)) return;  // no error: nothing to extrapolate
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
  if (poses < fewest_poses)
    fail(Status::invalid_argument, "a learning curve needs at least %zu poses, not %zu", fewest_poses, poses);
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
  fit_power_law(curve);
  return curve;
}

std::string outlook_text(const LearningCurve& curve) {
  if (curve.factor == 0) return "learning curve: the error is 0, more poses cannot lower it";
  if (curve.exponent < flat)
    return format("learning curve: more poses would not lower the error much: it goes as poses^%.2f", -curve.exponent);
  return format(
      "learning curve: twice the poses would give an mse of about %.1e: it falls as poses^%.2f, give or take %.0f %%",
      curve.mse_at(2 * static_cast<double>(curve.points.back().poses)), -curve.exponent, 100 * curve.deviation);
}

void measure_learning_curve(const PoseSet& training, const PoseSet& independent, const PackedModel& whole,
                            RigEvaluator* rig, const BakeOptions& options, BakeStats& stats, Progress& progress) {
  if (independent.size() == 0 || training.size() < fewest_poses) return;
  const Recipe& recipe = find_recipe(options.recipe);
  if (!learns(recipe, rig != nullptr)) {
    progress.note(format("no learning curve: the recipe \"%s\" learns nothing from poses", recipe.name));
    return;
  }
  if (recipe.evaluates_rig && rig && options.rig_budget > 0) {
    progress.note("no learning curve: its bakes would evaluate the rig beyond its budget");
    return;
  }
  const PoseSet measured = independent.subsampled(curve_poses);
  const auto errors_of = [&](const PackedModel& model) {
    return evaluate_model_on(model, measured, options.parallel, progress);
  };
  const auto train_and_measure = [&](std::span<const std::uint32_t> subset) {
    if (subset.size() == training.size()) return errors_of(whole);
    BakeOptions part = options;
    part.work = options.work / part_folder_name(subset.size());
    const OutputLock lock = OutputLock::of_folder(part.work);
    RecipeResult result = recipe.make(training.picked(subset), rig, part, progress);
    return errors_of(take_packed(result));
  };
  const LearningCurve curve = learning_curve(training.size(), options.seed, train_and_measure, progress);
  for (const LearningCurve::Point& point : curve.points)
    stats.learning.push_back({point.poses, point.errors.mse, point.errors.max});
  stats.notes.push_back(outlook_text(curve));
  progress.note(stats.notes.back());
}

std::string coverage_report(const PoseSet& training, const PoseSet& independent, const Parallel& parallel) {
  if (training.size() == 0 || independent.size() == 0) return "";
  const RigSchema& schema = training.source().schema();
  return coverage_text(
      measure_coverage(schema, control_groups(schema), training.controls(), independent.controls(), parallel), schema);
}

}  // namespace fb::bake
