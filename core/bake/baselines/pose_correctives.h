// Pose-space correctives: shapes driven by combinations of controls, chosen on recorded poses. The sparse interpolant
// of kanyuk2018.
#pragma once

#include <vector>

#include "bake/rig/pose_rows.h"
#include "model/network.h"

namespace fb::bake {

struct CorrectiveOptions {
  std::size_t max_count = 256;  // correctives
  std::size_t poses = 6000;     // sampled, evenly spaced; a fifth of them is the validation set
  std::uint32_t rounds = 4;     // of selection
};

struct PoseCorrectives {
  std::vector<Feature> features;  // products and minima of two ramps, and hats at the middle of one
  std::vector<float> shapes;      // features x 3 x vertices
};

// Matching pursuit (Mallat, Zhang, IEEE Trans. Signal Processing 41, 1993): each round adds the features whose values
// explain most of the remaining residual, and fits the shapes of all features anew by ridge regression on the leading
// principal components of `residual`. Stops when the error on the validation set no longer falls. `ramps` become the
// first features of the network; the new features refer to them by index.
PoseCorrectives find_correctives(const PoseRows& residual, const std::vector<Feature>& ramps,
                                 const CorrectiveOptions& options, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
