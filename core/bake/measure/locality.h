// Locality of controls: a control of an archive must not move a vertex that it does not move in the rig.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

struct LocalityOptions {
  std::uint32_t poses = 6;  // in which every control is moved: 2 from rest, to each end; the others random
  float active = 0.25f;     // share of the other controls that are away from rest in random poses
  double still = 1e-6;      // over D: a vertex that the rig moves no further counts as not moved
  double tolerance = 1e-4;  // over D: largest leak that does not count in Locality::above
  std::uint64_t seed = 1;
};

struct ControlLeak {
  std::string control;
  double leak = 0;           // largest displacement by the archive of a vertex that the rig does not move, over D
  std::uint32_t vertex = 0;  // the vertex with it
  // With all other controls at rest: the poses, those of them of clips that are not trained on, the largest error of a
  // vertex and how far the rig moves one, over D.
  std::size_t alone_poses = 0, unseen_poses = 0;
  double alone_error = 0, alone_motion = 0;
};

struct Locality {
  LocalityOptions options;
  double largest = 0;              // leak of any control
  double above = 0;                // share of the controls whose leak is over the tolerance
  std::vector<ControlLeak> leaks;  // of all controls measured, largest first
  // Recorded poses with one control off rest that this was measured on; 0: a live rig was.
  std::size_t recorded_poses = 0;
};

// Poses that measure_locality evaluates on a rig.
std::uint64_t locality_calls(const LocalityOptions& options, std::size_t controls);

// Options with the most poses that evaluate at most `calls` poses of the rig; none if one pose takes more.
std::optional<LocalityOptions> locality_within(std::uint64_t calls, std::size_t controls);

// Moves every control, in the rig and in archives of it: from rest to one end of its range and to the other; in random
// poses, from near rest to the farther end and otherwise to rest. A vertex that moving the control displaces in none of
// these poses of the rig must not be displaced by it in an archive. Evaluates locality_calls poses of the rig, for any
// number of archives; fails with invalid_argument on a recording, and as check_same_face does.
std::vector<Locality> measure_locality(std::span<const std::span<const std::byte>> archives, RigEvaluator& rig,
                                       const LocalityOptions& options, Progress& progress);

// The same from recorded poses in which a single control is off rest, of clips of any split: up to 16 a control, those
// furthest from rest. Only controls with such poses are measured; empty if there is none.
std::vector<Locality> recorded_locality(std::span<const std::span<const std::byte>> archives, Source& recording,
                                        const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
