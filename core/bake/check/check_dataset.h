// What is wrong with a dataset folder, all of it, and how well its poses cover a face.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/check/findings.h"
#include "bake/rig/source.h"
#include "bake/sampling/coverage.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct CheckedClip {
  std::string name;
  ClipKind kind = ClipKind::shot;
  Split split = Split::train;
  std::size_t frames = 0, evaluated = 0;  // evaluated: that have points
};

// Frames that move furthest, no two of them near each other.
struct LargeFrame {
  std::size_t clip = 0, frame = 0;  // clip: as in `clips`
  double motion = 0;                // of the worst vertex, over the diagonal
};

struct DatasetCheck {
  bool bakeable = false;  // there is no fault, and there are points to train on
  RigSchema schema;
  double diagonal = 0;  // of the rest mesh; 0: there is none
  std::size_t vertices = 0;
  std::vector<Finding> findings;  // faults first
  std::vector<CheckedClip> clips;
  // Of training poses, planned ones included, against those to measure on; against themselves where there are none.
  std::optional<Coverage> coverage;
  bool measured_on = false;          // whether there are poses to measure on
  std::vector<float> pair_shares;    // controls x controls: see pair_shares in coverage.h; empty as coverage
  std::vector<float> vertex_motion;  // of each vertex, the largest distance from rest, over the diagonal
  std::vector<LargeFrame> largest;
};

// Fails only where there is no folder, or with interrupted. Reads all of it, points in blocks.
DatasetCheck check_dataset(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
