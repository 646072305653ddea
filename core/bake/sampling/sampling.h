// Plans the poses of a dataset, evaluates them on a live rig and writes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// Clips of a plan that are told apart by name: near examples, and (followed by its number) of a round of active
// sampling.
inline constexpr const char* examples_clip = "like_examples";
inline constexpr const char* round_clip = "chosen_";

// The poses to draw where nobody says how many, as 0: all of a rig budget, else the usual number.
constexpr std::uint64_t poses_or_usual(std::uint64_t poses, std::uint64_t rig_budget) {
  constexpr std::uint64_t usual = 20000;
  return poses > 0 ? poses : rig_budget > 0 ? rig_budget : usual;
}

struct SamplingOptions {
  std::uint64_t poses = 20000;  // new training poses; the rig's own clips, extra clips and test poses come on top
  std::uint64_t seed = 1;
  // How new poses are spread over the kinds.
  // "paper": 25 % excitations, 55 % regional expressions, 20 % calisthenics, about a dozen controls at once.
  // "dense": 5 % excitations, 5 % calisthenics, 25 % all groups at once, 20 % heavy in one group, 45 % performances:
  // expressions on both sides of the face with many controls strongly active together. Within a rig budget, all
  // that was asked of single controls are excitations, and poses of many controls have amplitudes from 0.1 to 0.8.
  std::string mix = "dense";
  bool shots = true;       // include the rig's own clips, with their splits
  bool test_poses = true;  // include poses to test with: the rig's own clips of split test, else make_test_poses
  std::size_t drawn_test_poses = 2000;  // of make_test_poses
  // Different poses asked for at most in order to learn; `poses` is cut to that. The rig's own clips, those of the user
  // and test poses do not count, nor does a pose that is evaluated again. 0: no limit.
  std::uint64_t rig_budget = 0;
  // Puts the rest pose in the place of drawn poses that the rig cannot evaluate, up to a tenth of all, instead of
  // failing, with a note on each. Poses of the rig's clips and the user's, and those that the plan is made from, still
  // have to succeed.
  bool skip_failing = false;
  // Poses (frames x controls, in their ranges) near which a third of the new ones are asked that are not of single
  // controls: some of these frames, and variations of them. See read_examples.
  std::vector<float> examples = {};
  std::vector<Clip> extra = {};  // clips of the user; values outside their range are clamped and noted
};

// Controls to evaluate, clip by clip. All values are finite and within their ranges.
using PosePlan = std::vector<Clip>;

// New training poses of a plan: `poses`, or what the rig budget leaves. Fails with invalid_argument if that is none.
std::uint64_t poses_to_draw(const Source& rig, const SamplingOptions& options);

// Plans poses for a live rig, from its responses to single controls (see ControlResponses). Depends on rig and options
// only, not on threads.
PosePlan make_plan(RigEvaluator& rig, const SamplingOptions& options, Progress& progress);

// Test poses for a rig without clips of its own, all of split test: "random_15" and "random_35" (three tenths of the
// poses each, every control active with probability .15 or .35, uniform in its range) and "synthetic_shots" (smooth
// shots of 40 frames). Their random streams differ from those of make_plan for every seed.
std::vector<Clip> make_test_poses(const RigSchema& schema, std::uint64_t seed, std::size_t poses = 2000);

struct SampleReport {
  std::size_t left_out = 0;   // poses that failed, by this call and those before it: see SamplingOptions::skip_failing
  std::size_t poses = 0;      // of the whole plan
  std::size_t evaluated = 0;  // of those, in this call; the others were on the disk already
  std::uint64_t rig_calls = 0;  // poses the rig evaluated in this call, for whatever reason
  std::uint64_t asked = 0;  // different poses asked for in order to learn, by an interrupted call too: see rig_budget
};

// Writes a dataset folder: dataset.json and all controls first, then points in shards, each complete or absent. Shards
// of the same plan that exist are kept, so an interrupted call is continued by repeating it; a folder that holds
// another plan or dataset is refused, and so is a rig that puts one of 8 recorded poses elsewhere. A shard holds at
// most 64 MB and about 20 s of work; progress is in poses.
SampleReport sample_to_dataset(RigEvaluator& rig, const PosePlan& plan, const std::filesystem::path& directory,
                               Progress& progress);

// make_plan, then sample_to_dataset; a folder begun with the same rig and options is continued without a new plan.
SampleReport sample(RigEvaluator& rig, const SamplingOptions& options, const std::filesystem::path& directory,
                    Progress& progress);

// Adds clips to the end of a dataset that was sampled from this rig and keeps what is there. A clip that is there
// already is not added again; one of the same name with other controls is refused. Interrupted, it is continued by
// repeating it. Evaluates one recorded pose again, to see that the rig is still the same. `skip_failing`: see
// SamplingOptions.
SampleReport extend_dataset(RigEvaluator& rig, const std::vector<Clip>& clips, const std::filesystem::path& directory,
                            Progress& progress, bool skip_failing = false);

// The user's clip from a NumPy file of frames x controls.
Clip read_clip(const std::string& name, const std::filesystem::path& file, const RigSchema& schema);

}  // namespace fb::bake
