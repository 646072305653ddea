// Which poses a rig is asked for, and how the answers get onto the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

struct SamplingOptions {
  std::uint64_t poses = 20000;  // new training poses; the rig's own clips, extra and held-out poses come on top
  std::uint64_t seed = 1;
  // How new poses are spread over the kinds.
  // "paper": 25 % excitations, 55 % regional expressions, 20 % calisthenics, about a dozen controls at once.
  // "dense": 5 % excitations, 5 % calisthenics, 25 % all regions at once, 20 % heavy in one region, 45 % as animation
  // has them: expressions on both sides of the face with many controls far along together.
  std::string mix = "dense";
  bool shots = true;     // also take the rig's own clips, with their splits
  bool held_out = true;  // also poses to test with: the rig's own clips of split test, else make_test_poses
  // Poses the rig is asked for at most, probing and clips included; `poses` is cut to what they leave. 0: no limit.
  // Going on with a dataset asks for one pose of each of its clips again.
  std::uint64_t rig_budget = 0;
  std::vector<Clip> extra = {};  // clips of the user; values outside their range are clamped, and that is noted
};

// Controls to evaluate, clip by clip. All values are finite and within their ranges.
using PosePlan = std::vector<Clip>;

// New training poses a plan has: `poses`, or what the rig budget leaves. Fails with invalid_argument if that is none.
std::uint64_t poses_to_draw(const Source& rig, const SamplingOptions& options);

// Plans poses for a live rig. It first asks the rig for five values of every control, to see how much each control
// moves, where its response bends and which controls work against each other. Depends on rig and options only, not on
// threads.
PosePlan make_plan(RigEvaluator& rig, const SamplingOptions& options, Progress& progress);

// Unseen poses for a rig without clips of its own, all of split test: "random_15" and "random_35" (600 poses each,
// every control on with probability .15 or .35, uniform in its range) and "synthetic_shots" (20 smooth shots of 40
// frames). Random streams are apart from those of make_plan for every seed.
std::vector<Clip> make_test_poses(const RigSchema& schema, std::uint64_t seed);

struct SampleReport {
  std::size_t poses = 0;        // of the whole plan
  std::size_t evaluated = 0;    // of those, in this call; the others were on the disk already
  std::uint64_t rig_calls = 0;  // poses the rig was asked for in this call, for whatever reason
};

// Writes a dataset folder: dataset.json and all controls first, then points in shards, each complete or not there.
// Shards of the same plan that exist are kept, so an interrupted call is continued by repeating it; a folder that holds
// another plan or dataset is refused. A shard holds at most 64 MB and about 20 s of work; progress is in poses.
SampleReport sample_to_dataset(RigEvaluator& rig, const PosePlan& plan, const std::filesystem::path& directory,
                               Progress& progress);

// make_plan, then sample_to_dataset; a folder begun with the same rig and options is continued without planning again.
SampleReport sample(RigEvaluator& rig, const SamplingOptions& options, const std::filesystem::path& directory,
                    Progress& progress);

// Adds clips to the end of a dataset that was sampled from this rig and keeps what is there. Clips that are there
// already are no second time; one of the same name with other controls is refused. Interrupted, it is continued by
// repeating it. Asks for one pose that is there again, to see that the rig is still the same.
SampleReport extend_dataset(RigEvaluator& rig, const std::vector<Clip>& clips, const std::filesystem::path& directory,
                            Progress& progress);

// The user's clip from a NumPy file of frames x controls.
Clip read_clip(const std::string& name, const std::filesystem::path& file, const RigSchema& schema);

}  // namespace fb::bake
