// Where a face is furthest off its rig, in words.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bake/measure/evaluate.h"
#include "bake/measure/face_map.h"

namespace fb::bake {

// A vertex that is off in one pose of a set.
struct WorstVertex {
  double error = 0;      // over D
  std::size_t pose = 0;  // of the set
  std::uint32_t vertex = 0;
};

// "frame 12 of "story" at vertex 614 (tongue, lower middle), where "jaw_open" and "tongue_out" act": the place, and up
// to three controls without which the archive would move the vertex elsewhere in that pose, the most responsible first.
std::string describe_worst(const PackedModel& model, const FaceMap& map, const PoseSet& poses,
                           const WorstVertex& worst);

// Over D: errors that a user is told of.
constexpr double worst_vertex_bound = 1e-3;

// One sentence if the worst vertex is off by more than worst_vertex_bound: in the poses that were not trained on (none:
// no clips), or in those trained on, which `dependency` was measured on. The latter only if they are worse. `live`: a
// rig can be asked for more poses, which decides what the sentence advises.
std::optional<std::string> worst_vertex_warning(const PackedModel& model, const PoseSet& training,
                                                const Errors& dependency, const PoseSet& unseen,
                                                const std::optional<Errors>& independent, bool live,
                                                const Parallel& parallel);

}  // namespace fb::bake
