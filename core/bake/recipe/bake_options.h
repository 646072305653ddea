// What is baked, and how: read by recipes and by the pipeline.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// The paper's two uses of a face. A variant animates new shots, so shots are not in its training data; a backlot
// preserves a character whose shots exist, and trains on them.
enum class Use { variant, backlot };
const char* name_of(Use use);

// A file that a face is baked from.
struct SourceFile {
  std::string name;  // without folders
  std::uint64_t bytes = 0;
  std::string sha256;  // in hexadecimal digits
};

struct BakeOptions {
  std::string recipe = "hero";  // see recipe_names()
  Use use = Use::backlot;
  std::uint64_t seed = 1;
  std::uint64_t poses = 20000;  // sampled when the source is a live rig
  std::string mix = "dense";    // of those poses: "dense" or "paper"
  // Different poses asked of a live rig at most in order to learn, see SamplingOptions; `poses` is cut to that. 0: no
  // limit. A recipe finds here what is left for it, at least 1.
  std::uint64_t rig_budget = 0;
  // Poses near which a live rig is asked too, see SamplingOptions.
  std::vector<float> examples = {};
  // Poses that a live rig cannot evaluate are left out where that is possible, see SamplingOptions: also those of the
  // analysis, in place of which blendshapes are fitted to the training poses, and those the face is measured on.
  bool skip_failing = false;
  std::uint32_t epochs = 0;  // passes over the training poses; 0: the recipe's own
  // Targets of recipes that choose the precision of what they learnt; 0: the recipe's own precision.
  std::uint64_t max_bytes = 0;  // of the archive: the least error within them
  double max_error = 0;         // over the diagonal, on validation poses: the fewest bytes with it; after max_bytes
  // How much errors of normals count beside distances when a face is rounded, 0 or more: see PackOptions.
  double normal_weight = 1;
  bool force = false;  // where a target cannot be met, the nearest there is instead of a failure
  // Texts for the archive; empty: none. `created` is a date for the provenance.
  std::string licence, created;
  // What is said of the character, over what its source says of it (about.h): a JSON object; empty: nothing.
  std::string about;
  std::vector<std::byte> thumbnail;      // for the archive, a PNG; empty: none
  std::vector<SourceFile> source_files;  // for the provenance
  std::uint64_t reserved_bytes = 0;      // of max_bytes, for what is not learnt
  // Poses that come out as the source gives them, within rounding, see find_named_frames.
  std::vector<std::string> exact;
  // Adds to a packed face what takes bytes and is found once all else is done: the corrections of those poses; null:
  // nothing.
  std::function<void(PackedModel&)> complete;
  // Levels of detail: shares of the vertices, falling from below 1, or meshes (.obj, .glb) of vertices of the source;
  // both empty: none.
  std::vector<double> level_shares;
  std::vector<std::filesystem::path> level_meshes;
  std::vector<std::uint8_t> coarsest_levels;  // see LevelPlan: set for recipes by the pipeline
  int scale_exponent = 0;                     // of the power of two that the source is multiplied with; likewise
  // Trains on parts of the poses too, for the error by their number (BakeStats::learning): takes about as long as the
  // bake itself.
  bool learning_curve = false;
  Parallel parallel;
  // Folder for what makes resuming possible: sampled poses, evaluations of the rig, basis, checkpoints. Made if
  // missing; a later bake with the same options goes on from what is there, and with another target does not train
  // again.
  std::filesystem::path work;
  // Evaluations of a slow rig kept there at most, in bytes. Those that rig_budget counts are kept in any case.
  std::uint64_t cache_bytes = std::uint64_t{8} << 30;
  // Work folder of an earlier bake, of an earlier version of the rig, whose evaluations are taken over as far as they
  // still hold, see reuse_evaluations; empty: none.
  std::filesystem::path reuse;
};

// Whether the options have a target of bytes, error or time.
bool has_target(const BakeOptions& options);
// Whether they ask for levels of detail.
bool has_levels(const BakeOptions& options);

// The clips of the split train, without shots for a variant.
PoseSet training_poses(Source& data, Use use);

// Poses that are never trained on: the clips of the split test, or of validation where there are none. May be empty.
PoseSet independent_poses(Source& source);

}  // namespace fb::bake
