// The figures of baked or measured faces, read once from the JSON document of fb_report_details; docs/measuring.md
// explains them. Figures that were not measured are NaN, or absent where they are optional.
#pragma once

#include <cstddef>
#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

// Distances from the true rig over the diagonal; see fb_errors.
struct Errors {
  std::uint64_t frames = 0;  // 0: not measured
  double mse = 0, rms = 0, mean = 0, p99 = 0, max = 0, mfm = 0;
  std::uint64_t worst_frame = 0;
};

struct ClipErrors {
  std::string name, kind, split;
  Errors errors;
  std::vector<double> frame_mse, frame_max;  // one a frame; empty without quality
  std::vector<double> frame_expected;        // rms over D; empty for faces without expected errors
};

// How well a face's expected errors agree with measured ones, on the frames of shots.
struct Expectation {
  std::uint64_t frames = 0;
  double rank = 0, within_two = 0, constant_within_two = 0;
  std::uint64_t outside = 0;  // frames of all clips in which a control is outside of what was trained
};

struct KindErrors {
  std::string kind;
  Errors errors;
};

struct RegionErrors {
  std::string name, title;  // of the model; by place and what moves it
  std::vector<std::string> movers;
  std::uint64_t vertices = 0;
  double mse = 0, max = 0;
};

// In the frames in which the control and another one are off rest, of the vertices that it moves alone.
struct ControlErrors {
  std::string name;
  std::uint64_t vertices = 0, frames = 0;
  double mse = 0, max = 0;
};

// With all other controls at rest.
struct ErrorsAlone {
  std::string name;
  std::uint64_t poses = 0, unseen_poses = 0;
  double max = 0, motion = 0;
};

// Where surfaces touch in the true rig: how far the face opens gaps there, or moves one surface into the other.
struct Contact {
  std::uint64_t looked_at = 0, frames = 0, pairs = 0;  // frames searched, those with contact, touching pairs in them
  double rms = 0, max = 0;                             // errors of gaps, over the diagonal
  double visible = 0;                                  // what is seen
  std::uint64_t open = 0, deep = 0;                    // pairs further apart, and further in each other, than visible
  std::string worst_clip, worst_place;
  std::uint64_t worst_frame = 0, worst_vertex = 0;
  double worst = 0;  // error; negative: in each other
};

struct Quality {
  double normal_rms = 0, normal_p99 = 0;  // degrees
  double jitter = 0, border_jump = 0, inside_jump = 0;
  std::uint64_t jitter_frames = 0, border_edges = 0;
  Contact contact;
  std::vector<RegionErrors> regions;
  std::vector<ControlErrors> controls;
  std::vector<float> vertex_rms;           // one a vertex
  std::vector<std::size_t> vertex_region;  // one a vertex: an index into region_names, or their number for none
  std::vector<std::string> region_names;
};

// Motion that a control causes where it causes none in the rig.
struct Leak {
  std::string control;
  double distance = 0;  // over the diagonal
  std::uint64_t vertex = 0;
};

struct Locality {
  double largest = 0, share_above = 0;
  double tolerance = 0, still = 0;
  std::uint32_t poses = 0;
  std::uint64_t recorded_poses = 0;  // 0: measured on a live rig
  std::uint64_t controls = 0;        // measured
  std::vector<Leak> worst;           // the largest first
  std::vector<ErrorsAlone> alone;
};

// Bytes of the model that a pose reads.
struct TouchedBytes {
  std::uint64_t poses = 0;  // evaluated; 0: not measured
  double mean = 0;
  std::uint64_t p95 = 0, max = 0, all = 0;
};

// One network of the bake.
struct NetworkStats {
  std::string name;
  std::uint64_t vertices = 0, inputs = 0, coefficients = 0, parameters = 0, restarts = 0;
  double energy = 0, validation = 0;
  std::vector<double> training_loss, validation_loss;  // one an epoch
};

struct LearningPoint {
  double poses = 0, mse = 0, max = 0;
};

// What a rig was asked in one stage.
struct StageCalls {
  std::string name;
  std::uint64_t asked = 0, evaluated = 0;  // different poses in order to learn; all poses
  double seconds = 0;                      // in calls of the rig
};

struct BakeStats {
  std::vector<std::string> notes;
  std::vector<NetworkStats> networks;
  std::vector<LearningPoint> learning;
  std::string coverage;
};

struct FrameAddress {
  std::size_t clip = 0, frame = 0;
};

// One face: a method of `compare`, or the only one of `bake` and `eval`.
struct MethodFigures {
  std::string name, use;
  Errors total, dependency;  // on unseen clips, and on poses trained on
  std::vector<ClipErrors> clips;
  std::vector<KindErrors> kinds;
  std::vector<FrameAddress> worst_frames;  // by index into clips; the worst first
  std::uint64_t bytes = 0, parameters = 0, coefficients = 0, bones = 0, poses = 0, rig_calls = 0;
  double train_seconds = 0;
  TouchedBytes touched;
  std::optional<Quality> quality;
  std::optional<Locality> locality;
  std::optional<Expectation> expectation;
  BakeStats stats;
  std::span<const std::byte> archive;  // the report's
};

struct MethodFailure {
  std::string name, use, reason;
};

struct FaceFigures {
  std::string name, units;
  double diagonal = 0;
  std::optional<std::string> measured_split;
  std::vector<MethodFigures> methods;
  std::vector<MethodFailure> failures;
  std::vector<StageCalls> calls;  // of a live rig, by all methods
};

// A sentence on contact, for people.
std::string contact_text(const Contact& contact);

// A sentence on expected errors, and a warning where frames are outside of what was trained.
std::string expectation_text(const Expectation& expected);

// Of a report of bake, compare or eval, which must outlive the result.
FaceFigures read_figures(const facebaker::Report& report);

}  // namespace fb::tool
