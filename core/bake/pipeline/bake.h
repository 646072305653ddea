// From poses to an archive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "bake/measure/errors.h"
#include "bake/recipe/bake_options.h"
#include "bake/recipe/bake_stats.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

struct Baked {
  std::vector<std::byte> archive;
  std::size_t poses = 0;         // trained on
  std::uint64_t rig_calls = 0;   // poses a live rig evaluated in this call
  std::size_t coefficients = 0;  // columns of the basis
  std::size_t parameters = 0;    // trained numbers
  double train_seconds = 0;      // basis and network, without sampling and without what an earlier call had done
  Errors quantisation;           // of the packed model against that of floats, on training and random poses
  BakeStats stats;
};

// Samples (a live rig), trains, packs and verifies. Uses only clips of the split train; those of the split test, or of
// validation where there is none of them, are measured on for the certificate, where the rig's budget allows it.
Baked bake_face(Source& source, const BakeOptions& options, Progress& progress);

// bake, then writes the archive, which appears complete or not at all; that it can be written is tried first. Without a
// work folder it uses "<path>.work" and removes that once the archive is whole.
Baked bake_to_file(Source& source, const std::filesystem::path& path, BakeOptions options, Progress& progress);

// bake, once the poses are there.
Baked bake_recorded(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
