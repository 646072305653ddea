// The figures of baked and measured faces, as far as pages and documents show them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "figures/error_figures.h"
#include "figures/locality_figures.h"
#include "figures/quality_figures.h"
#include "figures/training_figures.h"

namespace fb {

struct FrameOfClip {
  std::size_t clip = 0;  // in EvalReport::clips
  std::size_t frame = 0;
  FrameErrors errors;
  std::string place = {};  // of the worst vertex, see FaceMap::name_of
};

template <class Visit, MaybeConst<FrameOfClip> Struct>
void visit_fields(Visit& visit, Struct& frame) {
  visit("clip", frame.clip);
  visit("frame", frame.frame);
  visit("mse", frame.errors.mse);
  visit("max", frame.errors.max);
  visit("vertex", frame.errors.worst_vertex);
  visit("place", frame.place);
}

// Errors of a face on clips.
struct EvalReport {
  std::string units;
  double diagonal = 0;
  std::vector<ClipErrors> clips;
  std::vector<KindErrors> kinds = {};      // of those clips, in the order of their first ones
  Errors total;                            // over the frames of all clips
  BytesRead bytes_read;                    // by poses of those clips that are shots, or of all if none is
  std::optional<Quality> quality;          // of the same clips, with Detail::quality
  std::vector<FrameOfClip> worst;          // see worst_frames; with Detail::quality
  std::optional<Expectation> expectation;  // with Detail::quality, of faces that have expected errors
};

template <class Visit, MaybeConst<EvalReport> Struct>
void visit_clips(Visit& visit, Struct& report) {
  visit.list("clips", report.clips, report.clips.size(), [&](auto& of_clip, auto& clip) {
    visit_fields(of_clip, clip);
    if (!of_clip.details()) return;
    of_clip.column("frame_expected", clip.frames, &FrameErrors::expected, report.expectation.has_value());
    of_clip.column("frame_mse", clip.frames, &FrameErrors::mse, true);
    of_clip.column("frame_max", clip.frames, &FrameErrors::max, true);
  });
}

// What a bake gives besides measurements.
struct BakedFace {
  std::vector<std::byte> archive = {};
  std::size_t poses = 0;         // trained on
  std::size_t coefficients = 0;  // columns of the basis
  std::size_t parameters = 0;    // trained numbers
  double train_seconds = 0;      // basis and network, without sampling and without what an earlier call had done
  BakeStats stats = {};
};

// A face that was baked or measured: in a comparison, a column of the paper's Table 1.
struct MethodReport : BakedFace {
  std::string name;                  // the recipe, such as "paper"; of a measured archive its name
  std::string use = "variant";       // or "backlot"
  EvalReport independent;            // on clips that nothing was trained on; of a measured archive those asked for
  Errors dependency;                 // on training poses (at most 4,000, evenly spaced)
  std::optional<Locality> locality;  // of a live rig within its budget, or of a recording with single poses
};

template <class Visit, MaybeConst<MethodReport> Struct>
void visit_fields(Visit& visit, Struct& method) {
  visit("name", method.name);
  visit("use", method.use);
  visit("total", method.independent.total);
  visit_clips(visit, method.independent);
  visit("kinds", method.independent.kinds);
  visit("dependency", method.dependency);
  visit.derived("bytes", method.archive.size());
  visit("touched_bytes", method.independent.bytes_read);
  visit("parameters", method.parameters);
  visit("coefficients", method.coefficients);
  visit("bones", method.stats.bones);
  visit("poses", method.poses);
  visit("train_seconds", method.train_seconds);
  visit("rig_calls", method.stats.rig_calls);
  visit("expected", method.independent.expectation);
  visit("quality", method.independent.quality);
  visit("locality", method.locality);
  if (!visit.details()) return;
  visit("worst_frames", method.independent.worst);
  visit("stats", method.stats);
}

// A method that could not be baked or measured.
struct MethodFailure {
  std::string name, use, reason;
};

template <class Visit, MaybeConst<MethodFailure> Struct>
void visit_fields(Visit& visit, Struct& failure) {
  visit("name", failure.name);
  visit("use", failure.use);
  visit("reason", failure.reason);
}

// What a live rig was asked in a stage of the work.
struct StageCalls {
  std::string stage;
  std::uint64_t asked = 0;      // different poses, in order to learn: see RigEvaluator::requested
  std::uint64_t evaluated = 0;  // all poses: see RigEvaluator::evaluated
  double seconds = 0;           // in calls of the rig, added up over those at once
};

template <class Visit, MaybeConst<StageCalls> Struct>
void visit_fields(Visit& visit, Struct& calls) {
  visit("stage", calls.stage);
  visit("asked", calls.asked);
  visit("evaluated", calls.evaluated);
  visit("seconds", calls.seconds);
}

// What pages about faces show: of a comparison several, otherwise one.
struct FaceFigures {
  std::string name, units;                     // of the rig
  double diagonal = 0;                         // of its rest mesh
  std::uint64_t rig_calls = 0;                 // poses a live rig was asked for in this call, by all methods together
  std::vector<StageCalls> asked_by_stage;      // the same, stage by stage
  std::optional<std::string> measured_split;   // of the clips measured on; none: all, or nothing was measured
  std::optional<Repeatability> repeatability;  // of a live rig, where its budget allowed for it
  std::vector<MethodReport> methods;           // every method as variant, then as backlot where shots to train on exist
  std::vector<MethodFailure> failures;
};

template <class Visit, MaybeConst<FaceFigures> Struct>
void visit_fields(Visit& visit, Struct& faces) {
  visit("name", faces.name);
  visit("units", faces.units);
  visit("diagonal", faces.diagonal);
  visit("rig_calls", faces.rig_calls);
  if (visit.details()) {
    visit("asked_by_stage", faces.asked_by_stage);
    visit("measured_split", faces.measured_split);
  }
  visit("repeatability", faces.repeatability);
  visit("methods", faces.methods);
  visit("failed", faces.failures);
}

}  // namespace fb
