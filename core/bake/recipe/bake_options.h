// What is baked, and how: read by recipes and by the pipeline.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
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
  std::uint64_t poses = 0;      // sampled when the source is a live rig; 0: see wanted_poses
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
  // Over the diagonal, of the worst vertex: the fewest bytes with it on validation poses; after max_bytes. A face that
  // is beyond it on any pose that nothing was fitted to fails, or is forced.
  double max_error = 0;
  // How much errors of normals count beside distances when a face is rounded, 0 or more: see PackOptions.
  double normal_weight = 1;
  std::string driven_joints = "keep";  // "none": see JointlessSource
  // A consent to learn from a character whose rights forbid it, and the certificate or key that it must be signed by,
  // see leave_to_learn; both or neither.
  std::string consent, consent_key;
  std::string consented;  // what the provenance says of it, a JSON object: set by the pipeline; empty: nothing
  bool force = false;  // where a target cannot be met, the nearest there is instead of a failure
  // Texts for the archive; empty: none. `created` is a date for the provenance.
  std::string licence, created;
  // What is said of the character, over what its source says of it (about.h): a JSON object; empty: nothing.
  std::string about;
  std::vector<std::byte> thumbnail;  // for the archive, a PNG; empty: none, or drawn
  // Draws the thumbnail of a finished archive that has none, a PNG; returns nothing for none. Called once, on a thread
  // of its own. See with_drawn_thumbnail for what its errors do. Null: none is drawn.
  std::function<std::vector<std::byte>(std::span<const std::byte> archive)> draw_thumbnail;
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

// An option that is a number, a flag, a word or a path, as every interface describes it: by this table the C interface
// reads its structs and options by name, the tool declares its command line, help, man pages and completion, and Python
// takes keywords. A new one is a member above, a row below, and the place that uses it.
struct OptionRow {
  enum class Part { sampling, training, limits, face };  // `compare` has the first two
  using Member = std::variant<std::uint32_t BakeOptions::*, std::uint64_t BakeOptions::*, double BakeOptions::*,
                              bool BakeOptions::*, std::string BakeOptions::*>;

  // `summary`: what the help says, a sentence without its full stop.
  constexpr OptionRow(const char* option, Member of, Part decides, const char* summary)
      : name(option), help(summary), member(of), part(decides) {}
  // "--name" on the command line, and what the help calls its value, "N"; "" of flags and words.
  constexpr OptionRow on_command_line(const char* argument_name, const char* value_name = "") const {
    OptionRow row = *this;
    row.argument = argument_name;
    row.value = value_name;
    return row;
  }
  constexpr OptionRow between(double lowest, double highest) const {
    OptionRow row = *this;
    row.least = lowest;
    row.most = highest;
    return row;
  }
  // What a word may be, with commas between.
  constexpr OptionRow one_of(const char* choices) const {
    OptionRow row = *this;
    row.words = choices;
    return row;
  }
  // The path of a file; otherwise a text is one of `words`.
  constexpr OptionRow path(const char* argument_name, const char* value_name) const {
    OptionRow row = on_command_line(argument_name, value_name);
    row.is_path = true;
    return row;
  }
  // Of the same poses the same face is baked, whatever it is.
  constexpr OptionRow keeps_face() const {
    OptionRow row = *this;
    row.changes_face = false;
    return row;
  }

  const char *name, *help, *argument = "", *value = "", *words = "", *since = "0.9";
  Member member;
  Part part;
  double least = 0, most = std::numeric_limits<double>::max();  // of numbers
  bool changes_face = true, is_path = false;
};

inline constexpr OptionRow option_table[] = {
    OptionRow(
        "poses", &BakeOptions::poses, OptionRow::Part::sampling,
        "Training poses to sample from the rig; 0: all of a rig budget, or 20,000, or 2,000 of a rig that is linear in "
        "its controls")
        .keeps_face(),
    OptionRow("rig_budget", &BakeOptions::rig_budget, OptionRow::Part::sampling,
              "Different poses to ask of the rig at most in order to learn; 0: any")
        .keeps_face(),
    OptionRow("mix", &BakeOptions::mix, OptionRow::Part::sampling,
              "Kinds of the sampled poses: paper (excitations, regional expressions, calisthenics) or dense (mostly "
              "many controls of many control groups at once)")
        .on_command_line("--mix")
        .one_of("paper,dense")
        .keeps_face(),
    OptionRow("seed", &BakeOptions::seed, OptionRow::Part::sampling,
              "Seed of everything random: the same seed gives the same bytes")
        .on_command_line("--seed", "N"),
    OptionRow("epochs", &BakeOptions::epochs, OptionRow::Part::training,
              "Passes over the training poses; 0: as many as the recipe takes")
        .on_command_line("--epochs", "N")
        .between(0, std::numeric_limits<std::uint32_t>::max()),
    OptionRow("learning_curve", &BakeOptions::learning_curve, OptionRow::Part::training,
              "Bake also on 1/8, 1/4 and 1/2 of the poses and measure on clips not trained on, for the report")
        .on_command_line("--learning-curve")
        .keeps_face(),
    OptionRow("consent", &BakeOptions::consent, OptionRow::Part::training,
              "Consent to learn from a character whose rights forbid it (a JSON file, its signature beside it: .sig)")
        .path("--consent", "FILE"),
    OptionRow("consent_key", &BakeOptions::consent_key, OptionRow::Part::training,
              "Certificate or public key, .pem, of whose leave counts: --consent must be signed by it")
        .path("--consent-key", "KEY"),
    OptionRow("max_bytes", &BakeOptions::max_bytes, OptionRow::Part::limits,
              "Size limit of the archive: the least error within it; 0: the precision of the recipe")
        .on_command_line("--max-bytes", "N"),
    OptionRow("max_error", &BakeOptions::max_error, OptionRow::Part::limits,
              "Largest error of a vertex allowed on poses not trained on, over the diagonal, in few bytes; 0: any")
        .on_command_line("--max-error", "E"),
    OptionRow("force", &BakeOptions::force, OptionRow::Part::limits,
              "Write the nearest there is where --max-bytes or --max-error cannot be met, instead of failing")
        .on_command_line("--force"),
    OptionRow("normal_weight", &BakeOptions::normal_weight, OptionRow::Part::face,
              "How much errors of normals count beside distances when the face is rounded, 0 to 4; 0: not")
        .on_command_line("--normal-weight", "W")
        .between(0, 4),
    OptionRow(
        "skip_failing", &BakeOptions::skip_failing, OptionRow::Part::face,
        "Leave out what a rig cannot evaluate, with a note, instead of failing: drawn poses, up to a tenth of all; "
        "the analysis of the rig, in place of which blendshapes are fitted to the training poses; measuring. "
        "Poses of clips to train on, and of controls moved alone, still have to succeed")
        .on_command_line("--skip-failing-poses")
        .keeps_face(),
    OptionRow("driven_joints", &BakeOptions::driven_joints, OptionRow::Part::face,
              "What becomes of joints that the controls drive: keep, or none (vertices alone learn what they do)")
        .on_command_line("--driven-joints")
        .one_of("keep,none"),
    OptionRow("cache_bytes", &BakeOptions::cache_bytes, OptionRow::Part::face,
              "Bytes of disk that evaluations of a slow rig may take in the work folder")
        .keeps_face(),
};

// The row of this name. Fails with invalid_argument, naming those there are.
const OptionRow& option_row(std::string_view name);
// What an option is, as text: "0.5", "dense", "1" of a flag.
std::string option_text(const BakeOptions& options, const OptionRow& row);
// Sets an option by its text. Fails with invalid_argument on what the row does not allow.
void set_option(BakeOptions& options, const OptionRow& row, std::string_view text);
// Fails with invalid_argument, naming it, on a number that the row does not allow. NaN is never allowed.
void check_option(const OptionRow& row, double value);

// Whether the options have a target of bytes, error or time.
bool has_target(const BakeOptions& options);
// Whether they ask for levels of detail.
bool has_levels(const BakeOptions& options);

// The clips of the split train, without shots for a variant.
PoseSet training_poses(Source& data, Use use);

// Poses that are never trained on: the clips of the split test, or of validation where there are none. May be empty.
PoseSet independent_poses(Source& source);

}  // namespace fb::bake
