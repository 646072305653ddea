// How long a pose takes, predicted: what evaluating it does is counted, and each of these things takes a fixed time on
// a class of machines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "model/packed_model.h"

namespace fb::bake {

// What evaluating a pose does, counted: the positions of all vertices in the source's order, of one pose by itself.
// The number of each of these things, in the order of pose_work_names:
//   poses         1
//   controls      controls and features, of which every pose computes those of controls
//   vertices      written
//   entries       places that values of active features are written to: inputs of networks, of gates and of row blocks
//   layers        of regions that are not skipped
//   weights       of these layers, in 64s; of a first layer, those of inputs that are not 0; 16-bit ones count twice
//   blocks        row blocks
//   moved         row blocks that move
//   coefficients  of regions that are not skipped, in row blocks; of 16-bit columns they count twice
//   summands      inputs of a moved row block (entries and coefficients), in fours, times its strips of 64 rows
//   misses        cache lines (64 bytes) beyond the first MiB: weights, summands, and 28 bytes a vertex
inline constexpr std::array pose_work_names = {"poses",  "controls", "vertices",     "entries",  "layers", "weights",
                                               "blocks", "moved",    "coefficients", "summands", "misses"};
using PoseWork = std::array<double, pose_work_names.size()>;

// Counts the work of poses of one model. Poses near exact ones, and levels of detail, take what it does not count.
class PoseWorkCounter {
 public:
  explicit PoseWorkCounter(const PackedModel& model);  // the model must outlive it

  // Of one pose (control_count values). Thread-safe. Fails with invalid_argument on another number of controls.
  PoseWork of_pose(std::span<const float> controls) const;

 private:
  const PackedModel* model_;
  std::vector<std::uint32_t> feature_entries_;  // by feature
  std::vector<std::uint32_t> owner_;            // by column: its feature, or features + its region
  double controls_ = 0;                         // PoseWork of every pose
};

// Machines that take about as long for the same work.
struct MachineClass {
  std::string name;           // of the instruction set that its figures hold for: see runtime::PoseKernels::name
  std::string processor;      // that they were measured on
  PoseWork nanoseconds = {};  // for one of each count; 0 or more

  double microseconds(const PoseWork& work) const;
};

// Names of the classes that are known.
std::vector<std::string> machine_names();

// A class by its name or, if the text begins with "{", by its document: {"format": "facebaker-machine", "version": 1,
// "name", "processor", "nanoseconds": {"poses": ..., ...}}. "": "avx512-vnni". Fails with not_found on another name,
// listing those there are, and with bad_data on a document that is none, naming what is missing.
MachineClass find_machine(const std::string& name_or_json);

// What poses take: means over the frames of one clip, in microseconds.
struct PoseTime {
  MachineClass machine;  // that it was predicted for
  double predicted = 0;
  double measured = 0;        // on this machine, by the least of some rounds
  std::string measured_with;  // name of the instruction set
};

// Predicted mean over the frames of a clip.
double mean_microseconds(const PackedModel& model, const Clip& clip, const MachineClass& machine);

}  // namespace fb::bake
