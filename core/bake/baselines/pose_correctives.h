// Correctives that fire when controls combine, found in recorded poses: the sparse interpolant of kanyuk2018.
#pragma once

#include <vector>

#include "bake/rig/pose_rows.h"
#include "model/network.h"

namespace fb::bake {

struct CorrectiveOptions {
  std::size_t most = 256;    // correctives
  std::size_t poses = 6000;  // looked at, evenly spaced; a fifth of them only to decide when to stop
  std::uint32_t rounds = 4;  // of choosing
};

// Features that pick a place in the space of controls, each with the shape it moves there.
struct PoseCorrectives {
  std::vector<Feature> features;  // products and minima of two ramps, and hats half-way along one
  std::vector<float> shapes;      // features x 3 x vertices
};

// In each round the features whose values explain most of what is left are taken (matching pursuit: Mallat, Zhang, IEEE
// Trans. Signal Processing 41, 1993), and the shapes of all are fitted anew by regularised least squares, in the
// leading components of `residual`; poses held back say when more of them do harm. `ramps` become the first features of
// the network, to which the new ones refer.
PoseCorrectives find_correctives(const PoseRows& residual, const std::vector<Feature>& ramps,
                                 const CorrectiveOptions& options, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
