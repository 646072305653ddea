#include "bake/pipeline/evaluation_plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "bake/analysis/rig_analysis.h"
#include "bake/face/region_poses.h"
#include "bake/measure/control_errors.h"
#include "bake/measure/repeatability.h"
#include "bake/pipeline/sample_poses.h"
#include "bake/sampling/active_sampling.h"
#include "bake/sampling/control_responses.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Rig calls of an analysis without a budget, for each control: 210 to 330 on the rigs of tests/rigs, 51 to 54 of
// avatars with morph targets alone.
constexpr std::uint64_t analysis_calls = 250, linear_analysis_calls = 50;
constexpr double short_seconds = 60;

// Of each control alone at an end of its range.
std::vector<float> end_poses(const RigEvaluator& rig) {
  std::vector<float> poses;
  for (std::size_t c = 0; c < rig.rest_pose().size(); ++c) {
    const Control& control = rig.schema().controls[c];
    poses.insert(poses.end(), rig.rest_pose().begin(), rig.rest_pose().end());
    poses[poses.size() - rig.rest_pose().size() + c] =
        control.maximum != control.rest ? control.maximum : control.minimum;
  }
  return poses;
}

// 0 if the rig fails: sampling tells on which pose.
double measure_pose_seconds(RigEvaluator& rig, Progress& progress) {
  constexpr double enough_seconds = 0.05;
  const PurposeScope purpose(rig, EvaluationPurpose::single_controls);
  const std::size_t width = rig.rest_pose().size();
  const std::vector<float> poses = end_poses(rig);
  std::vector<float> points;
  double seconds = 0, spent = 0;
  progress.begin(Phase::sampling, "timing the rig", 1);
  const auto time = [&](std::size_t count, bool fresh) {
    points.resize(count * rig.coordinate_count());
    const auto controls = std::span(poses).first(count * width);
    const std::uint64_t before = rig.evaluated();
    const auto start = std::chrono::steady_clock::now();
    fresh ? rig.evaluate(controls, count, points) : rig.evaluate_cached(controls, count, points);
    spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (rig.evaluated() > before) seconds = spent / static_cast<double>(rig.evaluated() - before);
  };
  try {
    const std::size_t least = std::min(rig.block_poses(), width);
    for (std::size_t count = 1; count <= 64 && spent < enough_seconds; count *= 8)
      time(std::clamp(count, std::min(least, std::size_t{64}), width), false);
    if (seconds == 0) time(1, true);  // all are in the cache
  } catch (const PoseError&) {
    seconds = 0;
  }
  progress.step(1);
  return seconds;
}

std::string time_text(double seconds) {
  if (seconds < 120) return format(seconds < 10 ? "%.2g s" : "%.0f s", seconds);
  return seconds < 7200 ? format("%.0f min", seconds / 60) : format("%.1f h", seconds / 3600);
}

std::string pose_time_text(double seconds) {
  return seconds < 1 ? format("%.2g ms", 1e3 * seconds) : format("%.2g s", seconds);
}

// Of the rig's own clips.
std::uint64_t sampled_frames(const RigEvaluator& rig, const SamplingOptions& sampling) {
  std::uint64_t frames = 0;
  for (const Clip& clip : rig.clips())
    if (clip.split != Split::test && sampling.shots) frames += clip.frames;
  return frames;
}

// The rig's own clips, those that are sampled and those that the face is measured on.
std::uint64_t clip_frames(const RigEvaluator& rig, const SamplingOptions& sampling) {
  std::uint64_t test = 0, validation = 0;
  for (const Clip& clip : rig.clips()) {
    if (clip.split == Split::test) test += clip.frames;
    if (clip.split == Split::validation) validation += clip.frames;
  }
  return sampled_frames(rig, sampling) + (test > 0 ? test : validation);
}

// On the disk of a folder that may not be there yet.
std::uint64_t free_bytes_at(std::filesystem::path folder) {
  std::error_code failed;
  if (folder.empty()) folder = ".";
  while (!std::filesystem::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  if (folder.empty()) folder = ".";
  const std::filesystem::space_info space = std::filesystem::space(folder, failed);
  return failed ? UINT64_MAX : space.available;
}

std::string bytes_text(std::uint64_t bytes) {
  return bytes < 995'000'000 ? format("%.3g MB", double(bytes) / 1e6) : format("%.3g GB", double(bytes) / 1e9);
}

std::string disk_text(const EvaluationPlan& plan) {
  const std::uint64_t all = plan.sampled_bytes + plan.kept_bytes;
  std::string text = "the work folder will take about " + bytes_text(all) + " of the disk";
  if (plan.kept_bytes > 0)
    text += ", " + bytes_text(plan.kept_bytes) +
            " of it for evaluations, without which a bake that is interrupted "
            "evaluates again";
  if (plan.free_bytes < all) text += "; there are only " + bytes_text(plan.free_bytes) + " free";
  return text;
}

}  // namespace

EvaluationPlan plan_evaluations(RigEvaluator& rig, const BakeOptions& options, RigUse use, Progress& progress,
                                bool linear) {
  const RigSchema& schema = rig.schema();
  const bool budgeted = options.rig_budget > 0;
  const SamplingOptions sampling = sampling_options(rig, options, SampledSplits::training, use);
  const std::uint64_t poses = poses_to_draw(rig, sampling),
                      alone = ControlResponses::poses_within(schema, sampling.rig_budget),
                      first = samples_actively(options, use) ? poses_before_ensemble(rig, sampling, {}) : poses;
  const std::uint64_t drawn = first - (budgeted ? std::min(alone, first) : 0),
                      near = sampling.examples.empty() ? 0 : drawn / 3;
  EvaluationPlan plan;
  const auto add = [&](EvaluationPurpose purpose, std::uint64_t expected, std::uint64_t most) {
    if (most > 0) plan.stages.push_back({purpose, expected, most});
  };
  const std::uint64_t joints = rig.counts()[static_cast<std::size_t>(EvaluationPurpose::joints)].asked;
  add(EvaluationPurpose::joints, joints, joints);
  const std::uint64_t alone_at_most = budgeted ? std::min(alone, first) : alone;
  add(EvaluationPurpose::single_controls, alone_at_most, budgeted ? alone_at_most : UINT64_MAX);
  add(EvaluationPurpose::drawn, drawn - near, drawn - near);
  add(EvaluationPurpose::examples, near, near);
  add(EvaluationPurpose::ensemble, poses - first, poses - first);
  const std::uint64_t left = budgeted ? options.rig_budget - std::min(options.rig_budget, poses) : UINT64_MAX;
  const bool analysed = use.evaluates && pays_to_analyse(schema, budgeted ? left : 0);
  const std::uint64_t calls = (linear ? linear_analysis_calls : analysis_calls) * schema.control_count();
  if (analysed) add(EvaluationPurpose::analysis, budgeted ? left : calls, left);
  const std::uint64_t learnt = poses + (options.use == Use::backlot ? sampled_frames(rig, sampling) : 0);
  const std::uint64_t of_regions = analysed && use.learns && !budgeted && !linear ? region_pose_count(learnt) : 0;
  add(EvaluationPurpose::regions, of_regions, of_regions);
  const std::uint64_t controls = control_error_calls(schema.control_count());
  const bool measured = !budgeted || (!analysed && left >= controls);
  const std::uint64_t measuring = repeated_poses + (measured ? controls : 0);
  add(EvaluationPurpose::measuring, measuring, measuring);
  const std::uint64_t clips = clip_frames(rig, sampling);
  add(EvaluationPurpose::clips, clips, clips);
  plan.pose_seconds = measure_pose_seconds(rig, progress);
  std::uint64_t asked = 0;
  for (const PlannedStage& stage : plan.stages) asked += stage.expected;
  plan.sampled_bytes =
      (poses + sampled_frames(rig, sampling)) * sizeof(float) * (rig.coordinate_count() + schema.control_count());
  plan.kept_bytes = std::min(asked * rig.kept_pose_bytes(), budgeted ? UINT64_MAX : options.cache_bytes);
  plan.free_bytes = free_bytes_at(options.work);
  return plan;
}

std::string text_of(const EvaluationPlan& plan, bool budgeted) {
  std::uint64_t total = 0;
  for (const PlannedStage& stage : plan.stages) total += stage.expected;
  const double seconds = static_cast<double>(total) * plan.pose_seconds;
  if (!budgeted && seconds < short_seconds)
    return format("the rig will be asked about %llu poses, which takes about %s at %s a pose; %s",
                  static_cast<unsigned long long>(total), time_text(seconds).c_str(),
                  pose_time_text(plan.pose_seconds).c_str(), disk_text(plan).c_str());
  std::string text = format("what the rig will be asked, at %s a pose:", pose_time_text(plan.pose_seconds).c_str());
  const auto add = [&](const char* name, std::uint64_t expected, std::uint64_t most) {
    const std::string number = format("%llu", static_cast<unsigned long long>(expected));
    text += format("\n  %-38s %9s poses %10s%s", name, number.c_str(),
                   time_text(static_cast<double>(expected) * plan.pose_seconds).c_str(),
                   most == UINT64_MAX ? "  or as many as it needs" : "");
  };
  for (const PlannedStage& stage : plan.stages) add(name_of(stage.purpose), stage.expected, stage.most);
  add("in all, about", total, total);
  return text + "\n" + disk_text(plan);
}

std::vector<StageCalls> calls_by_stage(const EvaluationCounts& counts) {
  std::vector<StageCalls> calls;
  for (std::size_t p = 0; p < counts.size(); ++p)
    if (counts[p].asked > 0 || counts[p].evaluated > 0)
      calls.push_back(
          {name_of(static_cast<EvaluationPurpose>(p)), counts[p].asked, counts[p].evaluated, counts[p].seconds});
  return calls;
}

}  // namespace fb::bake
