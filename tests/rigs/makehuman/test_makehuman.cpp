#include <doctest/doctest.h>

#include <cstdio>
#include <numbers>

#include "loaded_rig.h"
#include "support/rig_folder.h"

TEST_CASE("makehuman moves as its reference poses say") {
  if (!have_data("makehuman")) return;
  const LoadedRig rig(FB_PLUGIN_MAKEHUMAN);
  REQUIRE_MESSAGE(rig.status == FB_OK, rig.message);
  REQUIRE(rig->control_count == 270);
  REQUIRE(rig->vertex_count == 5101);
  CHECK(rig->polygon_count == 4962);
  CHECK(rig->clip_count == 0);
  CHECK(std::string(rig->units) == "dm");

  const rigs::RigFolder folder("makehuman");
  const auto first = folder.floats("ref_controls.npy", {24, 93}), angles = folder.floats("ref_fk.npy", {24, 177});
  std::vector<float> poses;
  for (std::size_t pose = 0; pose < 24; ++pose) {
    poses.insert(poses.end(), first.values.begin() + pose * 93, first.values.begin() + (pose + 1) * 93);
    for (std::size_t i = 0; i < 177; ++i)
      poses.push_back(static_cast<float>(angles.values[pose * 177 + i] * (180 / std::numbers::pi)));
  }
  const double error = largest_difference(rig.evaluate(poses), folder.floats("ref_verts.npy", {24, 5101, 3}).values);
  std::printf("makehuman: largest difference from the reference %.1e of the diagonal\n", error / rig.diagonal());
  CHECK(error < 1e-5 * rig.diagonal());
  check_promises(rig, poses);
}

TEST_CASE("makehuman's controls have names, ranges and regions") {
  if (!have_data("makehuman")) return;
  const LoadedRig rig(FB_PLUGIN_MAKEHUMAN);
  REQUIRE(rig.status == FB_OK);
  for (std::uint32_t i = 0; i < rig->control_count; ++i) {
    CHECK(rig->controls[i].minimum == (i < 93 ? 0.0f : -15.0f));
    CHECK(rig->controls[i].maximum == (i < 93 ? 1.0f : 15.0f));
  }
  CHECK(std::string(rig->controls[93].name) == "jaw.rx");
  CHECK(rig.group("LeftBrowDown") == "brows");
  CHECK(rig.group("eyebrows-left-up") == "brows");
  CHECK(rig.group("oculi01.L.ry") == "brows");
  CHECK(rig.group("eye-left-closure") == "lids");
  CHECK(rig.group("orbicularis03.R.rz") == "lids");
  CHECK(rig.group("eye.L.rx") == "eyes");
  CHECK(rig.group("oris05.rx") == "mouth");
  CHECK(rig.group("TongueOut") == "tongue");
  CHECK(rig.group("JawDrop") == "jaw");
}
