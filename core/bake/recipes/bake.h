// From poses to an archive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bake/measure/errors.h"
#include "bake/recipes/bake_diary.h"
#include "bake/rig/source.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb {

// What the face is for. A variant is used to make shots, so none may be in its training data; a backlot preserves a
// character whose shots exist.
enum class Use { variant, backlot };
Use use_from(std::string_view name);  // fails, listing the words there are
const char* name_of(Use use);

struct BakeOptions {
  std::string recipe = "hero";  // see recipe_names()
  Use use = Use::backlot;
  std::uint64_t seed = 1;
  std::uint64_t poses = 20000;  // sampled when the source is a live rig
  std::string mix = "dense";    // of those poses: "dense" or "paper"
  // Poses a live rig is asked for at most, probing and clips included; `poses` is cut to what that leaves. 0: no limit.
  // A recipe finds here what is left for it, at least 1.
  std::uint64_t rig_budget = 0;
  std::uint32_t epochs = 0;  // passes over the training poses; 0: the recipe's own
  // Targets of recipes that choose how precisely to keep what they learnt; 0: the recipe's own precision.
  std::uint64_t max_bytes = 0;  // of the archive: the least error within them
  double max_error = 0;         // over the diagonal, on poses kept back: the fewest bytes with it; after max_bytes
  // Texts that go into the archive as they are; empty: none. `created` is a date in the provenance.
  std::string licence, created;
  // Bakes again on parts of the poses to see what more of them would bring (BakeDiary::learning), which takes about as
  // long as the bake itself.
  bool learning_curve = false;
  Parallel parallel;
  // A folder for what makes resuming possible: sampled poses, basis, checkpoints. Made if missing; a later bake with
  // the same options goes on from what is there.
  std::filesystem::path work;
};

std::vector<std::string> recipe_names();

struct Baked {
  std::vector<std::byte> archive;
  std::size_t poses = 0;         // trained on
  std::uint64_t rig_calls = 0;   // poses a live rig was asked for in this call, for whatever reason
  std::size_t coefficients = 0;  // columns of the basis
  std::size_t parameters = 0;    // trained numbers
  double train_seconds = 0;      // basis and network, without sampling and without what an earlier call had done
  Errors quantisation;           // of the packed model against that of floats, on training and random poses
  BakeDiary diary;
};

// Samples (a live rig), trains, packs and verifies. Uses only clips of the split train; those of the split test, or of
// validation where there is none of them, are measured on for the certificate, where the rig's budget allows it.
Baked bake(Source& source, const BakeOptions& options, Progress& progress);

// bake, then writes the archive, which appears complete or not at all; that it can be written is tried first. Without a
// work folder it uses "<path>.work" and removes that once the archive is whole.
Baked bake_to_file(Source& source, const std::filesystem::path& path, BakeOptions options, Progress& progress);

}  // namespace fb
