#include "bake/pipeline/compare.h"

#include <algorithm>
#include <exception>

#include "bake/pipeline/bake_cache.h"
#include "bake/pipeline/pose_worth.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/pipeline/record.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t dependency_poses = 4000;

bool any_clip(const Source& data, bool (*wanted)(const Clip&)) {
  return std::any_of(data.clips().begin(), data.clips().end(), wanted);
}

MethodReport run_method(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  Baked baked = cached_bake(data, rig, options, progress);
  MethodReport report;
  report.name = options.recipe;
  report.use = options.use;
  report.independent = evaluate_archive(baked.archive, data, Split::test, options.parallel, progress, Detail::quality);
  report.dependency = evaluate_archive_on(baked.archive, training_poses(data, options.use).subsampled(dependency_poses),
                                          options.parallel, progress);
  report.bytes = baked.archive.size();
  report.parameters = baked.parameters;
  report.coefficients = baked.coefficients;
  report.poses = baked.poses;
  report.train_seconds = baked.train_seconds;
  report.archive = std::move(baked.archive);
  report.stats = std::move(baked.stats);
  if (options.learning_curve)
    report.stats.learning = measure_learning_curve(training_poses(data, options.use), unseen_poses(data),
                                                   report.archive, rig, options, progress);
  return report;
}

// How well each method keeps controls in their places, all on the same poses of the rig, if the budget still has them.
void add_locality(CompareReport& report, RigEvaluator& rig, const BakeOptions& options, Progress& progress) {
  const std::uint64_t left =
      options.rig_budget > 0 ? options.rig_budget - std::min(options.rig_budget, rig.requested()) : UINT64_MAX;
  std::optional<LocalityOptions> locality = locality_within(left, rig.schema().control_count());
  if (!locality) return progress.note("the rig's budget is spent: locality is not measured");
  std::vector<std::span<const std::byte>> archives;
  for (const MethodReport& method : report.methods) archives.push_back(method.archive);
  locality->seed = options.seed;
  std::vector<Locality> all = measure_locality(archives, rig, *locality, progress);
  for (std::size_t m = 0; m < all.size(); ++m) report.methods[m].locality = std::move(all[m]);
}

}  // namespace

CompareReport compare(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                      Progress& progress) {
  if (methods.empty()) fail(Status::invalid_argument, "there is no method to compare");
  for (const std::string& method : methods) {
    recipe_named(method);
    if (std::count(methods.begin(), methods.end(), method) > 1)
      fail(Status::invalid_argument, "the method \"%s\" is given more than once", method.c_str());
  }
  std::unique_ptr<Source> recorded;
  RigEvaluator evaluator(source, options.parallel, options.work / evaluations_name);
  const auto asks = [](const std::string& method) { return recipe_named(method).asks_rig; };
  const auto asking = static_cast<std::size_t>(std::count_if(methods.begin(), methods.end(), asks));
  if (source.live()) recorded = record(evaluator, options, Recording::with_test, asking > 0, progress);
  Source& data = recorded ? *recorded : source;
  if (!any_clip(data, [](const Clip& clip) { return clip.split == Split::test; }))
    fail(Status::bad_data,
         "\"%s\" has no test split: mark clips that are left out of training with \"split\": \"test\"",
         data.schema().name.c_str());

  if (training_poses(data, Use::backlot).size() == 0)
    fail(Status::bad_data, "\"%s\" has no clip of the split train to bake from", data.schema().name.c_str());

  CompareReport report{data.schema().name, data.schema().units, data.rest().diagonal(), 0, {}, {}, {}};
  const BakeOptions each = with_budget_left(options, evaluator, 2 * asking);  // at most two uses
  std::exception_ptr first_failure;
  for (const Use use : {Use::variant, Use::backlot}) {
    if (use == Use::backlot && training_poses(data, use).size() == training_poses(data, Use::variant).size()) continue;
    if (use == Use::variant && training_poses(data, use).size() == 0) {
      progress.note("every clip to train on is a shot: there is no variant to compare");
      continue;
    }
    const std::string coverage = coverage_of(training_poses(data, use), unseen_poses(data), options.parallel);
    for (const std::string& method : methods) {
      progress.note(format("baking the %s of \"%s\"", name_of(use), method.c_str()));
      BakeOptions one = each;
      one.recipe = method;
      one.use = use;
      one.work = options.work / (method + "." + name_of(use));
      try {
        report.methods.push_back(run_method(data, source.live() ? &evaluator : nullptr, one, progress));
        report.methods.back().stats.coverage = coverage;
      } catch (const Error& error) {
        if (error.status() == Status::interrupted) throw;
        if (!first_failure) first_failure = std::current_exception();
        progress.note(format("the %s of \"%s\" failed: %s", name_of(use), method.c_str(), error.what()));
        report.failures.push_back({method, use, error.what()});
      }
    }
  }
  if (report.methods.empty() && first_failure) std::rethrow_exception(first_failure);
  if (source.live()) add_locality(report, evaluator, options, progress);
  report.rig_calls = evaluator.evaluated();
  report.recorded = std::move(recorded);
  return report;
}

}  // namespace fb::bake
