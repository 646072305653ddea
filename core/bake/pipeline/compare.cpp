#include "bake/pipeline/compare.h"

#include <algorithm>
#include <exception>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/locality.h"
#include "bake/measure/repeatability.h"
#include "bake/pipeline/bake_cache.h"
#include "bake/pipeline/evaluation_plan.h"
#include "bake/pipeline/learning_curve.h"
#include "bake/pipeline/leave_to_learn.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/pipeline/sample_poses.h"
#include "bake/pipeline/scaled_archive.h"
#include "bake/recipe/work_folder.h"
#include "bake/rig/changed_rig.h"
#include "bake/rig/jointless_source.h"
#include "bake/rig/scaled_source.h"
#include "base/output_lock.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t dependency_poses = 4000;

void check_methods(const std::vector<std::string>& methods) {
  if (methods.empty()) fail(Status::invalid_argument, "there is no method to compare");
  for (const std::string& method : methods) {
    find_recipe(method);
    if (std::count(methods.begin(), methods.end(), method) > 1)
      fail(Status::invalid_argument, "the method \"%s\" is given more than once", method.c_str());
  }
}

void check_splits(Source& data) {
  const char* const name = data.schema().name.c_str();
  if (PoseSet(data, [](const Clip& clip) { return clip.split == Split::test; }).size() == 0)
    fail(Status::bad_data,
         "\"%s\" has no test split: mark clips that are left out of training with \"split\": \"test\"", name);
  if (training_poses(data, Use::backlot).size() == 0)
    fail(Status::bad_data, "\"%s\" has no clip of the split train to bake from", name);
}

MethodReport run_method(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  MethodReport report;
  static_cast<BakedFace&>(report) = cached_bake(data, rig, options, progress);
  const PackedModel model = archive::read_archive(report.archive).model;
  const PoseSet training = training_poses(data, options.use);
  report.name = options.recipe;
  report.use = name_of(options.use);
  report.independent = evaluate_model(model, data, Split::test, options.parallel, progress, Detail::quality);
  report.dependency = evaluate_model_on(model, training.subsampled(dependency_poses), options.parallel, progress);
  if (const auto warning = worse_than_rest(model, training, options.parallel)) {
    progress.note("warning: " + *warning);
    report.stats.notes.push_back("warning: " + *warning);
  }
  if (options.learning_curve)
    measure_learning_curve(training, independent_poses(data), model, rig, options, report.stats, progress);
  return report;
}

// Locality of all methods, on the same poses of the rig, if its budget allows for them.
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

// The same from the single poses of a recording, if it has any.
void add_recorded_locality(CompareReport& report, Source& recording, const Parallel& parallel, Progress& progress) {
  std::vector<std::span<const std::byte>> archives;
  for (const MethodReport& method : report.methods) archives.push_back(method.archive);
  std::vector<Locality> all = recorded_locality(archives, recording, parallel, progress);
  for (std::size_t m = 0; m < all.size(); ++m) report.methods[m].locality = std::move(all[m]);
}

// Whether a use is compared: a backlot only if it trains on more than a variant.
bool is_compared(Source& data, Use use, Progress& progress) {
  const std::size_t variant = training_poses(data, Use::variant).size();
  if (use == Use::backlot) return training_poses(data, use).size() != variant;
  if (variant == 0) progress.note("every clip to train on is a shot: there is no variant to compare");
  return variant > 0;
}

// Adds all methods on one use. `rig`: null without a live one. Returns the first failure.
std::exception_ptr compare_on(CompareReport& report, Source& data, RigEvaluator* rig,
                              const std::vector<std::string>& methods, const BakeOptions& options, Progress& progress) {
  std::exception_ptr first_failure;
  const Use use = options.use;
  const std::string coverage = coverage_report(training_poses(data, use), independent_poses(data), options.parallel);
  for (const std::string& method : methods) {
    progress.note(format("baking the %s of \"%s\"", name_of(use), method.c_str()));
    BakeOptions one = options;
    one.recipe = method;
    one.work = options.work / (method + "." + name_of(use));
    try {
      report.methods.push_back(run_method(data, rig, one, progress));
      report.methods.back().stats.coverage = coverage;
    } catch (const Error& error) {
      if (error.status() == Status::interrupted) throw;
      if (!first_failure) first_failure = std::current_exception();
      progress.note(format("the %s of \"%s\" failed: %s", name_of(use), method.c_str(), error.what()));
      report.failures.push_back({method, name_of(use), error.what()});
    }
  }
  return first_failure;
}

// compare, of a face of ordinary size.
CompareReport compare_ordinary(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                               Progress& progress) {
  std::unique_ptr<Source> recorded;
  RigEvaluator evaluator(source, options.parallel, options.work / evaluations_name);
  evaluator.set_cache_limit({options.cache_bytes, options.rig_budget > 0});
  check_rig_unchanged(evaluator, options.seed, options.work, progress);
  std::size_t evaluating = 0;
  RigUse use{false, false};  // of all methods
  for (const std::string& method : methods) {
    const Recipe& recipe = find_recipe(method);
    evaluating += recipe.evaluates_rig;
    use = {use.evaluates || recipe.evaluates_rig, use.learns || learns(recipe, source.live())};
  }
  if (source.live()) recorded = sample_poses(evaluator, options, SampledSplits::training_and_test, use, progress);
  Source& data = recorded ? *recorded : source;
  check_splits(data);

  CompareReport report;
  report.name = data.schema().name;
  report.units = data.schema().units;
  report.diagonal = data.rest().diagonal();
  report.measured_split = name_of(Split::test);
  BakeOptions each = with_budget_left(options, evaluator, 2 * evaluating);  // at most two uses
  std::exception_ptr first_failure;
  for (const Use use : {Use::variant, Use::backlot}) {
    if (!is_compared(data, use, progress)) continue;
    each.use = use;
    const auto failure = compare_on(report, data, source.live() ? &evaluator : nullptr, methods, each, progress);
    if (!first_failure) first_failure = failure;
  }
  if (report.methods.empty() && first_failure) std::rethrow_exception(first_failure);
  if (source.live()) {
    add_locality(report, evaluator, options, progress);
    report.repeatability = measure_repeatability(training_poses(data, Use::backlot), evaluator, progress);
    if (const auto warning = repeatability_warning(*report.repeatability)) progress.note("warning: " + *warning);
  } else {
    add_recorded_locality(report, data, options.parallel, progress);
  }
  report.rig_calls = evaluator.evaluated();
  report.asked_by_stage = calls_by_stage(evaluator.counts());
  report.recorded = std::move(recorded);
  return report;
}

}  // namespace

CompareReport compare(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                      Progress& progress) {
  if (!source.rest().driven.empty()) {
    progress.note(
        "methods are compared without the joints that the controls drive, which only compact, hero and untrained have");
    JointlessSource jointless(source);
    return compare(jointless, methods, options, progress);
  }
  check_methods(methods);
  leave_to_learn(methods, source, about_with(source, options), options, progress);
  const OutputLock lock = OutputLock::of_folder(options.work);
  const int exponent = scale_exponent(source.rest());
  if (exponent == 0) return compare_ordinary(source, methods, options, progress);
  ScaledSource ordinary(source, exponent);
  CompareReport report = compare_ordinary(ordinary, methods, options, progress);
  report.diagonal = source.rest().diagonal();
  for (MethodReport& method : report.methods) {
    method.archive = in_units_of_source(method.archive, exponent, options.seed);
    method.independent.diagonal = report.diagonal;
  }
  if (report.recorded) report.recorded = std::make_unique<ScaledSource>(std::move(report.recorded), -exponent);
  return report;
}

}  // namespace fb::bake
