#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "bake/measure/quality.h"
#include "bake/measure/touched_bytes.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/source.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "model/packed_model.h"

namespace fb::bake {

struct ClipErrors {
  std::string name;
  ClipKind kind;
  Split split;
  Errors errors;
  std::vector<FrameErrors> frames;  // with Detail::quality
};

// Over all clips of a kind.
struct KindErrors {
  ClipKind kind;
  Errors errors;
};

struct EvalReport {
  std::string units;
  double diagonal = 0;
  std::vector<ClipErrors> clips;
  std::vector<KindErrors> kinds = {};  // of those clips, in the order of their first ones
  Errors total;                        // over the frames of all clips
  TouchedBytes touched;                // by poses of those clips that are shots, or of all if none is
  std::optional<Quality> quality;      // of the same, with Detail::quality
};

// Quality takes normals and differences along edges in every frame besides.
enum class Detail { errors, quality };

// The face of the archive must be the face of the source: same controls, same vertices in the same places. Fails with
// bad_data, saying where they differ.
void check_same_face(const PackedModel& model, const Source& source);

// Compares a packed archive, through the runtime that ships, with the truth: every clip of `split` (all clips if
// empty). Fails as check_same_face does, and with bad_data when there is no such clip.
EvalReport evaluate_archive(std::span<const std::byte> archive, Source& source, std::optional<Split> split,
                            const Parallel& parallel, Progress& progress, Detail detail = Detail::errors);

// The same over any picked frames, as one figure.
Errors evaluate_archive_on(std::span<const std::byte> archive, const PoseSet& poses, const Parallel& parallel,
                           Progress& progress);

struct FrameOfClip {
  std::size_t clip = 0;  // in EvalReport::clips
  std::size_t frame = 0;
  FrameErrors errors;
};

// The frames with the largest errors of a vertex, largest first, none within half a second (12 frames) of another of
// its clip. Empty without Detail::quality.
std::vector<FrameOfClip> worst_frames(const EvalReport& report, std::size_t count);

}  // namespace fb::bake
