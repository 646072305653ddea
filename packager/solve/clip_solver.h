// A clip solved frame after frame.
#pragma once

#include <cstdint>
#include <facebaker/facebaker.hpp>
#include <vector>

#include "base/progress.h"
#include "solve/solve_target.h"

namespace fb::tool {

// See fb_solve_desc; `noise` 0: its default.
struct ClipPreferences {
  float noise = 0, nearness = 0.1f, sparsity = 0.1f, smoothness = 0, symmetry = 0;
  std::vector<std::uint8_t> movable;  // by control; empty: all
  bool find_motion = false;
  bool backwards = false;  // once more from the last frame to the first, each between its two neighbours
  std::uint32_t most_iterations = 40;
};

struct SolvedFrame {
  std::uint32_t iterations = 0, points = 0, worst_point = 0;
  float rms = 0, max = 0;  // of the points' distances, in units of the face
};

struct SolvedClip {
  std::vector<float> controls;  // frames x controls
  std::vector<float> motions;   // frames x 12; empty unless asked for
  std::vector<SolvedFrame> frames;
  std::vector<float> decided;         // one a control: the mean of some frames, see fb_solve_desc::decided
  std::vector<double> point_squares;  // one a point: the mean of squared distances, where it was measured
  std::vector<float> point_max;       // one a point: the largest distance
  double seconds = 0;                 // that solving took
};

// Solves all frames of a target, each from the frame before. Fails as fb_solve does, naming the frame.
SolvedClip solve_clip(const facebaker::Model& model, const SolveTarget& target, const ClipPreferences& preferences,
                      Progress& progress);

}  // namespace fb::tool
