#include "bake/pipeline/evaluation_plan.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "../memory_source.h"
#include "watched_progress.h"

namespace test_evaluation_plan {

using namespace fb;
using namespace fb::bake;

namespace {

MemorySource live_face(std::size_t controls) {
  MemorySource rig(
      controls, 5, [](const float* c, std::span<float> points) { points[0] += c[0]; }, true);
  rig.add_clip("walk", ClipKind::shot, Split::train, 40, 1, 1);
  rig.add_clip("talk", ClipKind::shot, Split::test, 30, 1, 2);
  return rig;
}

std::uint64_t expected(const EvaluationPlan& plan, EvaluationPurpose purpose) {
  const auto stage = std::ranges::find(plan.stages, purpose, &PlannedStage::purpose);
  return stage == plan.stages.end() ? 0 : stage->expected;
}

std::uint64_t to_learn(const EvaluationPlan& plan) {
  std::uint64_t poses = 0;
  for (const PlannedStage& stage : plan.stages)
    if (stage.purpose != EvaluationPurpose::clips && stage.purpose != EvaluationPurpose::measuring)
      poses += stage.expected;
  return poses;
}

}  // namespace

TEST_CASE("a plan within a budget spends it, stage by stage") {
  MemorySource rig = live_face(10);
  RigEvaluator evaluator(rig);
  BakeOptions options;
  options.poses = options.rig_budget = 1800;
  options.use = Use::variant;
  const EvaluationPlan plan = plan_evaluations(evaluator, options, {true}, silent_progress());
  CHECK(plan.pose_seconds > 0);
  CHECK(plan.sampled_bytes == 1200 * 4 * (10 + 3 * 25));  // what is asked for analysis is no part of the data
  CHECK(plan.kept_bytes == 0);                            // of a quick rig
  CHECK(plan.free_bytes < UINT64_MAX);
  CHECK(to_learn(plan) == 1800);
  CHECK(expected(plan, EvaluationPurpose::single_controls) == 40);  // at 4 values but rest
  CHECK(expected(plan, EvaluationPurpose::ensemble) == 580);        // half of the others
  CHECK(expected(plan, EvaluationPurpose::drawn) == 580);
  CHECK(expected(plan, EvaluationPurpose::analysis) == 600);  // as 60 calls a control are worthwhile
  CHECK(expected(plan, EvaluationPurpose::clips) == 30);      // a variant trains on no shots
  // Timing asks for poses that the plan holds.
  CHECK(evaluator.requested() <= 10);
  options.use = Use::backlot;
  options.examples = rig.clips()[0].controls;
  const EvaluationPlan like = plan_evaluations(evaluator, options, {false}, silent_progress());
  CHECK(to_learn(like) == 1800);
  CHECK(expected(like, EvaluationPurpose::examples) == (1800 - 40) / 3);
  CHECK(expected(like, EvaluationPurpose::clips) == 70);
  CHECK(expected(like, EvaluationPurpose::analysis) == 0);
}

TEST_CASE("a plan without a budget has poses of single regions, where the recipe evaluates the rig") {
  MemorySource rig = live_face(10);
  RigEvaluator evaluator(rig);
  BakeOptions options;
  options.poses = 1000;
  options.use = Use::variant;
  const auto of_regions = [&](bool evaluates) {
    return expected(plan_evaluations(evaluator, options, {evaluates}, silent_progress()), EvaluationPurpose::regions);
  };
  CHECK(of_regions(true) == 16000);
  CHECK(of_regions(false) == 0);
  options.use = Use::backlot;
  CHECK(of_regions(true) == 16640);  // for 40 frames of a clip, too
  const EvaluationPlan linear = plan_evaluations(evaluator, options, {true}, silent_progress(), true);
  CHECK(expected(linear, EvaluationPurpose::regions) == 0);
  CHECK(expected(linear, EvaluationPurpose::analysis) == 50 * rig.schema().control_count());
}

TEST_CASE("a plan is a sentence where all takes a moment, a table for a budget or a slow rig") {
  EvaluationPlan plan{{{EvaluationPurpose::drawn, 1000, 1000}, {EvaluationPurpose::analysis, 500, UINT64_MAX}}, 0.01};
  plan.sampled_bytes = 2'000'000'000;
  const std::string asked = "the rig will be asked about 1500 poses, which takes about 15 s at 10 ms a pose; ";
  const std::string disk = "the work folder will take about 2 GB of the disk";
  CHECK(text_of(plan, false) == asked + disk);
  CHECK(text_of(plan, true).ends_with("\n" + disk));
  plan.kept_bytes = 500'000'000;
  plan.free_bytes = 40'000'000;
  CHECK(text_of(plan, false) ==
        asked +
            "the work folder will take about 2.5 GB of the disk, 500 MB of it for evaluations, without which a bake "
            "that is interrupted evaluates again; there are only 40 MB free");
  const std::string table = text_of(plan, true);
  CHECK(table.starts_with("what the rig will be asked, at 10 ms a pose:\n  drawn poses "));
  CHECK(table.find("5 s  or as many as it needs") != std::string::npos);
  plan.pose_seconds = 2;
  CHECK(text_of(plan, false).find("50 min") != std::string::npos);
}

TEST_CASE("a rig that fails at once has a plan all the same") {
  MemorySource rig(
      4, 5, [](const float*, std::span<float>) { throw PoseError(Status::rig, 0, "no"); }, true);
  RigEvaluator evaluator(rig);
  CHECK(plan_evaluations(evaluator, {}, {true}, silent_progress()).pose_seconds == 0);
}

}  // namespace test_evaluation_plan
