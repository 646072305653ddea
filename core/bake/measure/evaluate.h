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

struct FrameOfClip {
  std::size_t clip = 0;  // in EvalReport::clips
  std::size_t frame = 0;
  FrameErrors errors;
};

// How expected errors of the whole face agree with measured ones, on the frames of shots: unseen motion.
struct Expectation {
  std::size_t frames = 0;
  double rank = 0;                 // Spearman's rank correlation
  double within_two = 0;           // share of frames measured within a factor of two of what was expected
  double constant_within_two = 0;  // the same of the frames' median in place of expected errors
  std::size_t outside = 0;         // frames, of all clips, in which a control is outside of what was trained
};

struct EvalReport {
  std::string units;
  double diagonal = 0;
  std::vector<ClipErrors> clips;
  std::vector<KindErrors> kinds = {};      // of those clips, in the order of their first ones
  Errors total;                            // over the frames of all clips
  BytesRead bytes_read;                    // by poses of those clips that are shots, or of all if none is
  std::optional<Quality> quality;          // of the same clips, with Detail::quality
  std::string worst_contact;               // where the vertex of the worst contact lies, see FaceMap::name_of
  std::vector<FrameOfClip> worst;          // see worst_frames; with Detail::quality
  std::optional<Expectation> expectation;  // with Detail::quality, of faces that have expected errors
};

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
