#pragma once

#include <cstdint>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// One control moved between rest and elsewhere while many others are away from rest.
struct FiniteDifference {
  std::uint32_t pose = 0, control = 0;
  float value = 0;    // elsewhere
  SparseShape moved;  // what the rig moved: elsewhere minus at rest, rig units
};

// Poses with 10 to 50 % of the controls on, and each control toggled in some of them.
struct DenseDifferences {
  std::vector<float> controls;       // poses x controls
  std::vector<float> displacements;  // poses x 3 x vertices
  std::vector<FiniteDifference> differences;
  std::size_t poses = 0;
};

// As many toggles a control, 16 at most, as the budget allows; each block of controls in a pose of its own.
DenseDifferences evaluate_differences(RigEvaluator& rig, std::uint64_t seed, Progress& progress);

// Distance over D by which toggles move each vertex, of the rig less what `base` (may be empty) moves:
// controls x vertices, the root mean square or the largest over a control's toggles.
enum class Over { largest, root_mean_square };
std::vector<float> difference_motion(const DenseDifferences& dense, const SparseBlendshapes& base, Over over,
                                     const RigEvaluator& rig);

}  // namespace fb::bake
