#pragma once

#include <cstdint>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// What one control moves while many others are away from rest: the difference of two evaluations.
struct FiniteDifference {
  std::uint32_t pose = 0, control = 0;  // pose: of DenseDifferences
  float value = 0;                      // of the control where it is away from rest
  SparseShape moved;                    // displacement there minus displacement with the control at rest, rig units
};

// Poses with 10 to 50 % of the controls active, and differences of every control in some of them.
struct DenseDifferences {
  std::vector<float> controls;       // poses x controls
  std::vector<std::uint32_t> judged;  // vertices (ascending) that displacements are of; empty: all
  std::vector<float> displacements;   // poses x 3 x vertices; see evaluate_displacements
  std::vector<FiniteDifference> differences;
  std::size_t poses = 0;
};

// 16 differences of each control; fewer where the budget asks for it. Of large faces displacements are kept of evenly
// spaced vertices, as many as fit 160 MiB.
DenseDifferences evaluate_differences(RigEvaluator& rig, std::uint64_t seed, Progress& progress);

// Evaluates the displacements once more, where they have been moved elsewhere.
void evaluate_displacements(RigEvaluator& rig, DenseDifferences& dense, Progress& progress);

// Distance over D by which the differences move each vertex, less what `base` (may be empty) moves there: controls x
// vertices, the largest or the root mean square over a control's differences.
enum class Statistic { largest, root_mean_square };
std::vector<float> difference_motion(const DenseDifferences& dense, const SparseBlendshapes& base, Statistic statistic,
                                     const RigEvaluator& rig);

}  // namespace fb::bake
