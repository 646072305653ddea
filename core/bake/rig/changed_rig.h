// Whether a rig still gives the points that it gave before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/earlier_evaluations.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// How far a rig puts the furthest vertex of a pose from where it put it before.
struct ChangedPose {
  std::uint64_t record = 0;  // of the earlier evaluations
  std::size_t vertex = 0;
  double distance = 0;  // over D
};

// Over D: distances below are none.
inline constexpr double least_rig_tolerance = 1e-5;

// Evaluates poses of a cache again. Counts against no budget.
class RigComparison {
 public:
  // `answers`: takes what is evaluated, and what it has is not evaluated; null: neither. All must outlive this.
  RigComparison(RigEvaluator& rig, EarlierEvaluations& earlier, EvaluationCache* answers = nullptr);

  // In the order of the records; without those that cannot be read.
  std::vector<ChangedPose> compare(std::span<const std::uint64_t> records, EvaluationStage& stage);
  // What distances may be without the rig being another: least_rig_tolerance, as rest poses are held to, or four times
  // what lies between two evaluations of up to 8 of these records, where that is more.
  double tolerance(std::span<const std::uint64_t> records);

 private:
  void evaluate(std::span<const float> controls, std::span<float> points);

  RigEvaluator& rig_;
  EarlierEvaluations& earlier_;
  EvaluationCache* const answers_;
};

// Evaluates 8 poses of the rig's cache again, spread over it by the seed; counts against no budget. Fails with
// invalid_argument, naming `work`, the pose, a vertex and its distance, if the rig puts it elsewhere now. Does nothing
// while the cache is empty.
void check_rig_unchanged(RigEvaluator& rig, std::uint64_t seed, const std::filesystem::path& work, Progress& progress);

// "1.2e-3 of the diagonal (0.02 cm)"
std::string distance_text(const RigEvaluator& rig, double distance);

}  // namespace fb::bake
