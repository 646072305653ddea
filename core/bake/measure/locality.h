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
#include "figures/locality_figures.h"

namespace fb::bake {

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
