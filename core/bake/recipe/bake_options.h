// What a bake is asked for: read by recipes and by who calls them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"

namespace fb::bake {

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
  double max_error = 0;         // over the diagonal, on validation poses: the fewest bytes with it; after max_bytes
  bool force = false;           // where a target cannot be met, the nearest there is instead of a failure
  // Texts that go into the archive as they are; empty: none. `created` is a date in the provenance.
  std::string licence, created;
  // Bakes again on parts of the poses to see what more of them would bring (BakeStats::learning), which takes about as
  // long as the bake itself.
  bool learning_curve = false;
  Parallel parallel;
  // A folder for what makes resuming possible: sampled poses, basis, checkpoints. Made if missing; a later bake with
  // the same options goes on from what is there.
  std::filesystem::path work;
};

// The clips of the split train, without shots for a variant.
PoseSet training_poses(Source& data, Use use);

}  // namespace fb::bake
