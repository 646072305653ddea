// Errors of packed models against their source.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/bytes_read.h"
#include "bake/measure/errors.h"
#include "bake/measure/quality.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/source.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "figures/face_figures.h"
#include "model/packed_model.h"

namespace fb::bake {

// What is measured: errors alone, or normals, jitter, seams, contact, regions and controls too, which takes longer.
enum class Detail { errors, quality };

// Checks that a model is of the source's face: same controls, same vertices at the same rest positions. Fails with
// bad_data, saying where they differ.
void check_same_face(const PackedModel& model, const Source& source);

// Compares a packed model, evaluated by the runtime, with the source: every clip of `split` (all clips if empty). Fails
// as check_same_face does, and with bad_data when there is no such clip.
EvalReport evaluate_model(const PackedModel& model, Source& source, std::optional<Split> split,
                          const Parallel& parallel, Progress& progress, Detail detail = Detail::errors);

// The same over any picked frames, as one figure.
Errors evaluate_model_on(const PackedModel& model, const PoseSet& poses, const Parallel& parallel, Progress& progress);

// A warning if a face is further from some of these poses, at most 256, than its rest mesh, which does not move.
std::optional<std::string> worse_than_rest(const PackedModel& model, const PoseSet& poses, const Parallel& parallel);

// evaluate_model of the model in an archive, scaled as scaled_source.h says.
EvalReport evaluate_archive(std::span<const std::byte> archive, Source& source, std::optional<Split> split,
                            const Parallel& parallel, Progress& progress, Detail detail = Detail::errors);

// Up to `count` of the frames with the largest errors of a vertex, that differ from each other: at least half a second
// (12 frames) apart in a clip, and poses further apart than half the way from rest to the farther of the two, in units
// of the controls' reach. First those with at least a quarter of the largest error whose worst vertices also lie at
// least 5 % of the diagonal apart, largest error first; then others, in the same order. `source`: has the clips of the
// report, which has Detail::quality.
std::vector<FrameOfClip> worst_frames(const EvalReport& report, const Source& source, std::size_t count);

}  // namespace fb::bake
