#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <set>

#include "aura/aura_weights.h"
#include "loaded_rig.h"
#include "support/rig_folder.h"

using rigs::RigFolder;

TEST_CASE("aura moves as its reference poses say") {
  if (!have_data("aura")) return;
  const LoadedRig rig(FB_PLUGIN_AURA);
  REQUIRE_MESSAGE(rig.status == FB_OK, rig.message);
  REQUIRE(rig->control_count == 72);
  REQUIRE(rig->vertex_count == 5944);
  CHECK(rig->polygon_count == 5924);
  CHECK(std::string(rig->units) == "cm");

  const RigFolder folder("aura");
  const auto poses = folder.floats("ref_poses.npy", {0, 72});
  const double error =
      largest_difference(rig.evaluate(poses.values), folder.floats("ref_verts.npy", {0, 5944, 3}).values);
  std::printf("aura: largest difference from the reference %.1e of the diagonal\n", error / rig.diagonal());
  CHECK(error < 1e-5 * rig.diagonal());
  check_promises(rig, poses.values);
}

TEST_CASE("aura's shape weights are those of the reference") {
  if (!have_data("aura")) return;
  const RigFolder folder("aura");
  const rigs::AuraWeights weights(folder.text("rig.json"));
  REQUIRE(weights.size() == 267);
  const auto poses = folder.floats("ref_poses.npy", {0, 72}), expected = folder.floats("ref_weights.npy", {0, 267});
  double error = 0;
  for (std::size_t pose = 0; pose < poses.shape[0]; ++pose) {
    double got[267];
    weights.evaluate(poses.values.data() + pose * 72, got);
    for (std::size_t i = 0; i < 267; ++i) error = std::max(error, std::abs(got[i] - expected.values[pose * 267 + i]));
  }
  CHECK(error < 1e-6);
}

TEST_CASE("aura's controls lie in seven regions") {
  if (!have_data("aura")) return;
  const LoadedRig rig(FB_PLUGIN_AURA);
  REQUIRE(rig.status == FB_OK);
  std::set<std::string> groups;
  for (std::size_t i = 0; i < rig->control_count; ++i) groups.insert(rig->controls[i].group);
  CHECK(groups == std::set<std::string>{"brows", "cheeks", "eyes", "jaw", "lids", "mouth", "nose"});
  CHECK(rig.group("innerBrowRaiser_L") == "brows");
  CHECK(rig.group("eyesClosed_R") == "lids");
  CHECK(rig.group("upperLidRaiser_L") == "lids");
  CHECK(rig.group("upperLipRaiser_L") == "mouth");
  CHECK(rig.group("chinRaiser_T") == "mouth");
  CHECK(rig.group("nasolabialFurrow_R") == "nose");
}

TEST_CASE("aura's clips are split, named and within range") {
  if (!have_data("aura")) return;
  const LoadedRig rig(FB_PLUGIN_AURA);
  REQUIRE(rig.status == FB_OK);
  struct Clip {
    std::int32_t kind, split;
    std::uint32_t frames;
    bool operator==(const Clip&) const = default;
  };
  const std::map<std::string, Clip> expected = {
      {"alex_rom_3.first", {FB_CLIP_SHOT, FB_SPLIT_TRAIN, 2015}},
      {"alex_rom_3.second", {FB_CLIP_SHOT, FB_SPLIT_TEST, 2015}},
      {"facegood_2_01", {FB_CLIP_SHOT, FB_SPLIT_TRAIN, 3295}},
      {"facegood_2_02", {FB_CLIP_SHOT, FB_SPLIT_TRAIN, 3360}},
      {"facegood_2_03", {FB_CLIP_SHOT, FB_SPLIT_TRAIN, 3356}},
      {"facegood_3_15", {FB_CLIP_SHOT, FB_SPLIT_TEST, 1472}},
      {"meta_combinations", {FB_CLIP_REGIONAL, FB_SPLIT_TRAIN, 1900}},
      {"meta_performance", {FB_CLIP_SHOT, FB_SPLIT_TEST, 300}},
      {"meta_single_excitations", {FB_CLIP_EXCITATION, FB_SPLIT_TRAIN, 600}},
  };
  std::map<std::string, Clip> clips;
  bool within = true;
  for (std::size_t i = 0; i < rig->clip_count; ++i) {
    const fb_rig_clip& clip = rig->clips[i];
    clips[clip.name] = {clip.kind, clip.split, clip.frames};
    CHECK(clip.fps == 30);
    for (std::size_t k = 0; k < std::size_t{clip.frames} * rig->control_count; ++k)
      within = within && clip.controls[k] >= 0 && clip.controls[k] <= 1;
  }
  CHECK(within);
  CHECK(clips == expected);

  const auto whole = RigFolder("aura").floats("clip_alex_rom_3.npy", {4030, 72});
  for (std::size_t i = 0; i < rig->clip_count; ++i) {
    if (std::string(rig->clips[i].name) == "alex_rom_3.second")
      CHECK(std::equal(whole.values.begin() + 2015 * 72, whole.values.end(), rig->clips[i].controls));
  }
}
