// How well training poses cover the poses a face is used in.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/sampling/control_responses.h"
#include "base/parallel.h"
#include "model/rig_schema.h"

namespace fb::bake {

// A control is strongly active from this fraction of the way from rest to an end of its range on.
inline constexpr float strong_activation = 0.6f;

// A figure of both sets of poses: [0] training poses, [1] target poses, which the training poses are to cover.
template <class T>
using TrainingTarget = std::array<T, 2>;

struct ControlCoverage {
  TrainingTarget<float> lowest{}, highest{};  // extremes toward either end, as fractions of the way from rest (0..1)
  TrainingTarget<double> strong{};            // share of the poses in which it is strongly active
  double beyond = 0;  // share of the target poses in which it is further from rest than in any training pose
};

// Two controls strongly active at once, each toward one end of its range.
struct PairCoverage {
  std::array<std::uint32_t, 2> controls{};
  std::array<bool, 2> up{};
  TrainingTarget<double> share{};  // of the poses
};

// Poses restricted to the controls of one group; distances are Euclidean, controls in units of their reach.
struct GroupCoverage {
  std::string name;
  // Distance of training poses to the nearest other training pose: median and 95th percentile.
  double median = 0, percentile_95 = 0;
  double target_median = 0;  // of target poses to the nearest training pose
  double uncovered = 0;      // share of the target poses further than percentile_95: .05 if both sets are alike
};

struct Coverage {
  TrainingTarget<std::size_t> poses{};
  std::vector<ControlCoverage> controls;                   // all, in the schema's order
  TrainingTarget<std::vector<std::size_t>> strong_counts;  // [n]: poses with n controls strongly active
  std::vector<GroupCoverage> groups;                       // most uncovered first
  std::vector<PairCoverage> pairs;                         // at most 50, the most under-represented first
};

// Compares two sets of poses (poses x controls, rig values; neither empty) through groups of controls, such as
// ControlResponses or control_groups gives. Distances are measured on at most 10,000 training and 1,000 target poses,
// evenly spaced; everything else on all. Does not depend on threads.
Coverage measure_coverage(const RigSchema& schema, std::span<const ControlGroup> groups,
                          std::span<const float> training, std::span<const float> target, const Parallel& parallel);

// In how many of the poses two controls are strongly active at once, whatever the ends: controls x controls shares of
// the poses, in the diagonal those in which one is. Does not depend on threads.
std::vector<float> pair_shares(const RigSchema& schema, std::span<const float> poses, const Parallel& parallel);

// In words and small tables, for a terminal or a report.
std::string coverage_text(const Coverage& coverage, const RigSchema& schema);

}  // namespace fb::bake
