// Whether controls stay where they belong: a control must not move a vertex that it does not move in the rig.
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
  std::uint32_t poses = 6;  // that every control is moved in: alone to each end, then in random ones
  float active = 0.25f;     // of the other controls are away from rest
  double still = 1e-6;      // over D: what the rig moves less, it does not move
  double tolerance = 1e-4;  // over D: what the archive moves less, it moves by accident
  std::uint64_t seed = 1;
};

struct ControlLeak {
  std::string control;
  double leak = 0;           // furthest that the archive moves a vertex which the rig leaves alone, over D
  std::uint32_t vertex = 0;  // that one
};

struct Locality {
  LocalityOptions options;
  double largest = 0;              // of all leaks
  double above = 0;                // share of the controls whose leak is over the tolerance
  std::vector<ControlLeak> leaks;  // of all controls, largest first
};

// What measure_locality asks of a rig.
std::uint64_t locality_calls(const LocalityOptions& options, std::size_t controls);

// Options that ask for at most `calls` poses; none if that is too few to move every control once.
std::optional<LocalityOptions> locality_within(std::uint64_t calls, std::size_t controls);

// Moves every control alone, to one end of its range and to the other, and in random poses, from near rest to the
// farther end and from elsewhere to rest, in the rig and in archives of it. A vertex that the control moves in none of
// these poses of the rig is one that it may not move in an archive. Asks a live rig for the poses of locality_calls,
// whatever the number of archives; fails with invalid_argument on another source, and as check_same_face does.
std::vector<Locality> measure_locality(std::span<const std::span<const std::byte>> archives, RigEvaluator& rig,
                                       const LocalityOptions& options, Progress& progress);

}  // namespace fb::bake
