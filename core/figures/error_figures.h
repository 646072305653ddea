// Errors of a face against its rig: the figures of every report. With e the distance of a predicted vertex from the
// true one and D the rest mesh's bounding-box diagonal. Kinds and splits of clips are words, as dataset.json has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "figures/member_list.h"

namespace fb {

// Errors of a channel over the length of its range, over all frames.
struct ChannelErrors {
  std::string name;
  double rms = 0, max = 0;
};

// Over all vertices and frames.
struct Errors {
  std::size_t frames = 0;
  double mse = 0;  // mean of e^2 / D^2
  double rms = 0;  // its square root
  // Standard error of rms as that of more such frames, if each was drawn by itself; consecutive ones tell less.
  double rms_deviation = 0;
  double mean = 0;  // mean of e / D
  double p99 = 0;   // 99th percentile of e / D; resolved to 1 %
  double max = 0;   // largest e / D
  double mfm = 0;   // mean over frames of the frame's largest e / D: of the frame maxima
  double p99fm = 0;  // 99th percentile of the frame maxima
  std::size_t worst_frame = 0;
  std::uint32_t worst_vertex = 0;  // of that frame
  std::vector<ChannelErrors> channels = {};
};

// The figures alone, without where they are.
template <class Visit, MaybeConst<Errors> Struct>
void visit_distances(Visit& visit, Struct& errors) {
  visit("frames", errors.frames);
  visit("mse", errors.mse);
  visit("rms", errors.rms);
  visit("mean", errors.mean);
  visit("p99", errors.p99);
  visit("max", errors.max);
  visit("mfm", errors.mfm);
  visit("p99fm", errors.p99fm);
}

template <class Visit, MaybeConst<Errors> Struct>
void visit_fields(Visit& visit, Struct& errors) {
  visit_distances(visit, errors);
  visit("worst_frame", errors.worst_frame);
  visit("worst_vertex", errors.worst_vertex);
}

// Errors of one frame, over D^2 and D (see Errors).
struct FrameErrors {
  float mse = 0, max = 0;
  std::uint32_t worst_vertex = 0;
  // What the face itself says, see ExpectedErrors: rms of its vertices, and controls outside of what was trained.
  float expected = 0;
  std::uint32_t outside = 0;
};

struct ClipErrors {
  std::string name, kind, split;
  Errors errors;
  std::vector<FrameErrors> frames;  // with Detail::quality
};

template <class Visit, MaybeConst<ClipErrors> Struct>
void visit_fields(Visit& visit, Struct& clip) {
  visit("name", clip.name);
  visit("kind", clip.kind);
  visit("split", clip.split);
  visit_fields(visit, clip.errors);
}

// Over all clips of a kind.
struct KindErrors {
  std::string kind;
  Errors errors;
};

template <class Visit, MaybeConst<KindErrors> Struct>
void visit_fields(Visit& visit, Struct& kind) {
  visit("kind", kind.kind);
  visit_fields(visit, kind.errors);
}

// Errors of a packed face on poses of its training data that nothing was fitted to: what to expect of unseen poses of
// the same kinds.
struct HeldBackErrors {
  Errors total;
  std::vector<KindErrors> kinds;  // in the order of ClipKind, those that there are
};

template <class Visit, MaybeConst<HeldBackErrors> Struct>
void visit_fields(Visit& visit, Struct& held_back) {
  visit_fields(visit, held_back.total);
  visit("kinds", held_back.kinds);
}

// How expected errors of the whole face agree with measured ones, on the frames of shots: unseen motion.
struct Expectation {
  std::size_t frames = 0;
  double rank = 0;                 // Spearman's rank correlation
  double within_two = 0;           // share of frames measured within a factor of two of what was expected
  double constant_within_two = 0;  // the same of the frames' median in place of expected errors
  std::size_t outside = 0;         // frames, of all clips, in which a control is outside of what was trained
};

template <class Visit, MaybeConst<Expectation> Struct>
void visit_fields(Visit& visit, Struct& expected) {
  visit("frames", expected.frames);
  visit("rank", expected.rank);
  visit("within_two", expected.within_two);
  visit("constant_within_two", expected.constant_within_two);
  visit("outside", expected.outside);
}

// Bytes of the model that a pose reads, see BytesReadCounter.
struct BytesRead {
  double mean = 0;
  std::uint64_t p95 = 0, max = 0;   // over poses
  std::uint64_t runtime_bytes = 0;  // BytesReadCounter::total
  std::size_t poses = 0;            // counted
};

template <class Visit, MaybeConst<BytesRead> Struct>
void visit_fields(Visit& visit, Struct& bytes) {
  visit("poses", bytes.poses);
  visit("mean", bytes.mean);
  visit("p95", bytes.p95);
  visit("max", bytes.max);
  visit("all", bytes.runtime_bytes);
}

// Distances of vertices between two evaluations of the same poses by a rig, over D.
struct Repeatability {
  std::size_t poses = 0;
  double rms = 0, max = 0;
};

template <class Visit, MaybeConst<Repeatability> Struct>
void visit_fields(Visit& visit, Struct& repeatability) {
  visit("poses", repeatability.poses);
  visit("rms", repeatability.rms);
  visit("max", repeatability.max);
}

}  // namespace fb
