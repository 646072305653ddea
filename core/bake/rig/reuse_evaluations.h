// Takes over what was evaluated of an earlier version of a rig, as far as the rig still answers so.
#pragma once

#include <cstdint>
#include <filesystem>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// Copies evaluations from the cache `from` of an earlier bake into the cache `to` of one that begins. They are checked
// by evaluating again, which counts against no budget:
//   1. Of each control, the single pose (all other controls at rest) that is furthest from rest. Those that lie
//      elsewhere now name the changed controls; poses with one of these off rest are dropped.
//   2. Of the other poses a twentieth, at least 32, with every control off rest on either side in one of them at least.
//      Where one of these lies elsewhere, all single poses of its controls are evaluated; if none has changed, no
//      single control explains it, and everything is dropped. Otherwise step 2 is repeated.
// Controls are the same by name, see EarlierEvaluations: poses off rest of a control that is gone, or outside a range,
// are dropped before.
// Distances count as change beyond RigComparison::tolerance. What was evaluated for this is kept in any case. Notes say
// what was kept, dropped, and which controls have changed, where and by how much.
//
// Does nothing, with a note, where there are no evaluations, or none of a mesh of these vertices and polygons with this
// rest, and nothing if `to` has reused evaluations already: the same call goes on after an interruption. Fails with
// invalid_argument if `to` has other evaluations; with not_found if the folder of `from` is not there.
// Whether evaluations were taken over by this call.
bool reuse_evaluations(RigEvaluator& rig, const std::filesystem::path& from, const std::filesystem::path& to,
                       std::uint64_t seed, Progress& progress);

}  // namespace fb::bake
