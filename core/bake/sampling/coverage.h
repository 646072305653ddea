// What a set of training poses does not cover of the poses a face will be asked for.
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

// A control is "far along" when it is at least this part of the way from rest to an end of its range.
inline constexpr float far_along = 0.6f;

// Both sets side by side, [0] trained on and [1] asked for.
template <class T>
using TrainedAsked = std::array<T, 2>;

struct ControlCoverage {
  TrainedAsked<float> lowest{}, highest{};  // furthest toward either end, as parts of the way from rest (0..1)
  TrainedAsked<double> far{};               // share of the poses in which it is far along
  double beyond = 0;                        // share of the asked poses in which it is further than in any trained one
};

// Two controls far along at once, each toward its end.
struct PairCoverage {
  std::array<std::uint32_t, 2> controls{};
  std::array<bool, 2> up{};
  TrainedAsked<double> share{};  // of the poses
};

// Poses seen through the controls of one region; distances are Euclidean, controls in units of their reach.
struct GroupCoverage {
  std::string name;
  // From trained poses to the nearest other trained pose: median, and what 95 % of them have at most.
  double typical = 0, usual = 0;
  double asked = 0;      // median distance of asked poses to the nearest trained one
  double uncovered = 0;  // share of the asked poses for which it is more than `usual`: .05 if both sets are alike
};

struct Coverage {
  TrainedAsked<std::size_t> poses{};
  std::vector<ControlCoverage> controls;                // all, in the schema's order
  TrainedAsked<std::vector<std::size_t>> far_together;  // [n]: poses with n controls far along
  std::vector<GroupCoverage> regions;                   // most uncovered first
  std::vector<PairCoverage> pairs;                      // at most 50, the most asked for what was trained first
  double uncovered = 0;                                 // share of the asked poses that any region calls uncovered
};

// Compares two sets of poses (poses x controls, rig values; neither empty). Regions are groups of controls, such as
// ControlResponses finds or control_groups gives. Of large sets 10,000 trained and 1,000 asked poses, evenly spaced,
// are looked at for distances; all for everything else. Does not depend on threads.
Coverage measure_coverage(const RigSchema& schema, std::span<const ControlGroup> regions,
                          std::span<const float> trained, std::span<const float> asked, const Parallel& parallel);

// In words and small tables, for a terminal or a report.
std::string coverage_text(const Coverage& coverage, const RigSchema& schema);

}  // namespace fb::bake
