// What a check of a dataset folder found: all that is wrong with it, and what its poses cover.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "figures/member_list.h"

namespace fb {

// A sentence that names clip, frame, vertex, control or file.
struct Finding {
  std::string kind;  // "file", "controls", "points", ...: an interface of documents
  std::string clip;  // "": none
  std::string text;
};

template <class Visit, MaybeConst<Finding> Struct>
void visit_fields(Visit& visit, Struct& finding) {
  visit("kind", finding.kind);
  visit("clip", finding.clip);
  visit("text", finding.text);
}

struct CheckedClip {
  std::string name, kind, split;
  std::size_t frames = 0, evaluated = 0;  // evaluated: that have points
};

template <class Visit, MaybeConst<CheckedClip> Struct>
void visit_fields(Visit& visit, Struct& clip) {
  visit("name", clip.name);
  visit("kind", clip.kind);
  visit("split", clip.split);
  visit("frames", clip.frames);
  visit("evaluated", clip.evaluated);
}

// A control's declaration, and what poses use of its range; NaN where there is no coverage.
struct UsedRange {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  std::string name, group;
  float minimum = 0, maximum = 0, rest = 0;
  double lowest = unknown, highest = unknown;  // of all poses to train on
  double strong = unknown;                     // share of these in which it is strongly active
  double beyond = unknown;                     // share of the poses to measure on in which it goes further
};

template <class Visit, MaybeConst<UsedRange> Struct>
void visit_fields(Visit& visit, Struct& control) {
  visit("name", control.name);
  visit("group", control.group);
  visit("min", control.minimum);
  visit("max", control.maximum);
  visit("default", control.rest);
  visit("lowest", control.lowest);
  visit("highest", control.highest);
  visit("strong", control.strong);
  visit("beyond", control.beyond);
}

// [n]: poses with n controls strongly active, of those to train on and to measure on.
struct ActiveCounts {
  std::vector<std::size_t> training;
  std::optional<std::vector<std::size_t>> measured;  // none: there is nothing to measure on
};

template <class Visit, MaybeConst<ActiveCounts> Struct>
void visit_fields(Visit& visit, Struct& active) {
  visit("training", active.training);
  visit("measured", active.measured);
}

// Pairs of controls that are strongly active at once.
struct PairsSeen {
  std::size_t all = 0, seen = 0;                  // of the controls, and in poses to train on
  std::vector<std::vector<std::string>> missing;  // two names each: in poses to measure on, and never in those
};

template <class Visit, MaybeConst<PairsSeen> Struct>
void visit_fields(Visit& visit, Struct& pairs) {
  visit("all", pairs.all);
  visit("seen", pairs.seen);
  visit("missing", pairs.missing);
}

// Frames that move furthest, no two of them near each other.
struct LargeFrame {
  std::size_t clip = 0, frame = 0;  // clip: in DatasetFigures::clips
  double motion = 0;                // of the worst vertex, over the diagonal
};

template <class Visit, MaybeConst<LargeFrame> Struct>
void visit_fields(Visit& visit, Struct& frame) {
  visit("clip", frame.clip);
  visit("frame", frame.frame);
  visit("motion", frame.motion);
}

struct DatasetFigures {
  std::string folder, name, units;
  double diagonal = 0;  // of the rest mesh; 0: there is none
  std::size_t vertices = 0;
  bool bakeable = false;  // there is no fault, and there are points to train on
  std::vector<Finding> faults, warnings;
  std::size_t poses = 0, evaluated = 0;  // of all clips
  std::vector<CheckedClip> clips;
  std::vector<UsedRange> controls;
  // Of training poses, planned ones included, against those to measure on; none where there are no training poses.
  std::optional<ActiveCounts> active;
  std::optional<PairsSeen> pairs;
  std::optional<std::string> coverage;  // sentences and tables; none where there is nothing to measure on
  std::vector<float> vertex_motion;     // of each vertex, the largest distance from rest, over the diagonal
  std::vector<float> pair_shares;       // controls x controls: share of the poses that have both; empty as `pairs`
  std::vector<LargeFrame> largest_frames;
};

template <class Visit, MaybeConst<DatasetFigures> Struct>
void visit_fields(Visit& visit, Struct& figures) {
  visit("dataset", figures.folder);
  visit("name", figures.name);
  visit("units", figures.units);
  visit("diagonal", figures.diagonal);
  visit("vertices", figures.vertices);
  visit("bakeable", figures.bakeable);
  visit("faults", figures.faults);
  visit("warnings", figures.warnings);
  visit("poses", figures.poses);
  visit("evaluated", figures.evaluated);
  visit("clips", figures.clips);
  visit("controls", figures.controls);
  visit("active", figures.active);
  visit("pairs", figures.pairs);
  visit("coverage", figures.coverage);
  if (!visit.details()) return;
  visit("vertex_motion", figures.vertex_motion);
  visit("pair_shares", figures.pair_shares);
  visit("largest_frames", figures.largest_frames);
}

}  // namespace fb
