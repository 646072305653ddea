#include "bake/pipeline/pose_worth.h"

#include "archive/writer.h"
#include "bake/measure/evaluate.h"
#include "bake/pipeline/learning_curve.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/sampling/coverage.h"
#include "base/file.h"

namespace fb::bake {
namespace {

constexpr std::size_t measured_poses = 1000, fewest_poses = 16;

}  // namespace

PoseSet unseen_poses(Source& source) {
  const auto of = [&](Split split) { return PoseSet(source, [=](const Clip& clip) { return clip.split == split; }); };
  PoseSet test = of(Split::test);
  return test.size() > 0 ? test : of(Split::validation);
}

std::string coverage_of(const PoseSet& trained, const PoseSet& asked, const Parallel& parallel) {
  if (trained.size() == 0 || asked.size() == 0) return "";
  const RigSchema& schema = trained.source().schema();
  return coverage_text(measure_coverage(schema, control_groups(schema), trained.controls(), asked.controls(), parallel),
                       schema);
}

std::vector<LearningPoint> measure_learning_curve(const PoseSet& poses, const PoseSet& asked,
                                                  std::span<const std::byte> whole, RigEvaluator* rig,
                                                  const BakeOptions& options, Progress& progress) {
  if (asked.size() == 0 || poses.size() < fewest_poses) return {};
  const Recipe& recipe = recipe_named(options.recipe);
  if (recipe.asks_rig && rig && options.rig_budget > 0) {
    progress.note("no learning curve: it would ask the rig for more than its budget");
    return {};
  }
  const PoseSet measured = asked.subsampled(measured_poses);
  const auto errors_of = [&](std::span<const std::byte> archive) {
    return evaluate_archive_on(archive, measured, options.parallel, progress);
  };
  const auto train_and_measure = [&](std::span<const std::uint32_t> some) {
    if (some.size() == poses.size()) return errors_of(whole);
    BakeOptions part = options;
    part.work = options.work / ("learning." + std::to_string(some.size()));
    make_folder(part.work);
    const RecipeResult result = recipe.make(poses.picked(some), rig, part, progress);
    return errors_of(archive::write_archive(pack_model(result.model, result.packing), {}));
  };
  std::vector<LearningPoint> points;
  for (const LearningCurve::Point& point :
       learning_curve(poses.size(), options.seed, train_and_measure, progress).points)
    points.push_back({point.poses, point.errors.mse, point.errors.max});
  return points;
}

}  // namespace fb::bake
