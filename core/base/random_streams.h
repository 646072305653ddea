// What the seed of a bake, a dataset or a measurement is used for. Every use draws from random streams of its own, one
// for each item (a pose, a control, a round), so that nothing that is drawn depends on how much of another kind was,
// and poses that are measured on are no poses that were learnt from.
#pragma once

#include <cstdint>

#include "base/random.h"

namespace fb {

// The order is part of what a seed gives: a new use is added at the end. Each is drawn from in one place of the code,
// which the test tidy_tree holds.
enum class Stream : std::uint64_t {
  // Sampled poses.
  regional = 1,
  calisthenics,
  dense,
  heavy,
  random_15,
  random_35,
  synthetic_shots,
  validation,
  performances,
  candidates,
  choice,
  learning_curve,
  amplitude,
  examples,
  sampling_rounds,
  // Analysis of the rig.
  difference_order,
  difference_poses,
  difference_values,
  curve_validation,
  missed_correctives,
  pair_projection,
  // What is learnt.
  subspace_start,
  local_basis,
  regions,
  cluster_starts,
  region_networks,
  ensemble_networks,
  network_weights,
  pose_order,
  level_turns,
  bounding_shots,
  // Checks and measurements.
  unchanged_rig,
  reused_evaluations,
  quantisation_poses,
  proof,
  repacked_poses,
  locality_poses,
  control_values,
  control_poses,
  control_moves,
  error_regions,
  compared_faces,
  // Exports and benchmarks of the tool.
  skinned_fit,
  skinned_measure,
  exported_shapes,
  bench_clip,
  bench_network,
  // Numbered after those that there were, so that these draw as before.
  region_poses,
  linear_probes,
};

inline Random open_stream(std::uint64_t seed, Stream use, std::uint64_t item = 0) {
  return Random(seed, static_cast<std::uint64_t>(use) << 48 | item);
}

// A seed for something that has streams of its own, such as one of several networks.
inline std::uint64_t seed_of(std::uint64_t seed, Stream use, std::uint64_t item = 0) {
  return open_stream(seed, use, item).next();
}

}  // namespace fb
