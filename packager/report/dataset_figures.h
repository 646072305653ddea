// What a check of a dataset folder found, read once from the JSON documents of fb_check.
#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <string>
#include <vector>

#include "report/figures.h"

namespace fb::tool {

struct DatasetFinding {
  std::string kind, clip, text;
};

struct DatasetClip {
  std::string name, kind, split;
  std::uint64_t frames = 0, evaluated = 0;  // evaluated: that have points
};

struct ControlRange {
  std::string name, group;
  double minimum = 0, maximum = 0, rest = 0;
  double lowest = 0, highest = 0;  // of all poses to train on; NaN where there are none
  double strong = 0;               // share of these in which it is strongly active
  double beyond = 0;               // share of the poses to measure on in which it goes further
};

struct DatasetFigures {
  std::string folder, name, units;
  double diagonal = 0;  // 0: there is no rest mesh
  bool bakeable = false;
  std::vector<DatasetFinding> faults, warnings;
  std::vector<DatasetClip> clips;
  std::vector<ControlRange> controls;
  // [n]: poses with n controls strongly active, of those to train on and to measure on; empty where there are none.
  std::vector<double> active_training, active_measured;
  std::uint64_t pairs = 0, pairs_seen = 0;
  std::vector<std::string> missing_pairs;  // "smile_L and jaw_open", which poses to measure on have
  std::string coverage;                    // tables in words; "" where there is nothing to measure on
  std::vector<float> vertex_motion;        // one a vertex, over the diagonal
  std::vector<float> pair_shares;          // controls x controls
  std::vector<FrameAddress> largest_frames;
};

// Of a report of fb_check.
DatasetFigures read_dataset_figures(const facebaker::Report& report);

// For a terminal, and as Markdown.
std::string dataset_text(const DatasetFigures& figures);

}  // namespace fb::tool
