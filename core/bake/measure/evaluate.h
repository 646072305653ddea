#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "bake/measure/touched_bytes.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/source.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb {

struct ClipErrors {
  std::string name;
  ClipKind kind;
  Split split;
  Errors errors;
};

struct EvalReport {
  std::string units;
  double diagonal = 0;
  std::vector<ClipErrors> clips;
  Errors total;          // over the frames of all clips
  TouchedBytes touched;  // by poses of those clips that are shots, or of all if none is
};

// Compares a packed archive, through the runtime that ships, with the truth: every clip of `split` (all clips if
// empty). Fails with bad_data when controls, vertices or rest mesh are not those of the archive, or when there is no
// such clip.
EvalReport evaluate_archive(std::span<const std::byte> archive, Source& source, std::optional<Split> split,
                            const Parallel& parallel, Progress& progress);

// The same over any picked frames, as one figure.
Errors evaluate_archive_on(std::span<const std::byte> archive, const PoseSet& poses, const Parallel& parallel,
                           Progress& progress);

}  // namespace fb
