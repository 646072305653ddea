// What has changed between two archives, as the tool says it.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/writer.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"
#include "turning_joints.h"

namespace test_tool_diff {

using Json = nlohmann::json;

namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void write(const std::string& path, const fb::PackedModel& model, const char* certificate = "") {
  fb::write_file(path, fb::archive::write_archive(model, {}, {"", certificate}));
}

Json diff_of(const std::string& before, const std::string& now, int exit_code) {
  const ToolRun run = run_tool({"diff", before, now, "--json"});
  CHECK_MESSAGE(run.exit_code == exit_code, run.err);
  return Json::parse(run.out);
}

}  // namespace

TEST_CASE("a face is equal to itself, whatever its texts say") {
  const ScratchFolder folder;
  const std::string before = folder / "before.fbk", now = folder / "now.fbk";
  fb::PackedModel model = fb::tiny_packed_model();
  write(before, model, R"({"dependency":{"mse":1e-8}})");
  model.provenance = R"({"recipe":"tiny","seed":2})";
  write(now, model, R"({"dependency":{"mse":2e-8}})");
  CHECK(run_tool({"diff", before, before}).exit_code == 0);
  const ToolRun run = run_tool({"diff", before, now});
  CHECK(run.exit_code == 0);
  for (const char* part :
       {"certificate dependency.mse: 1e-08 -> 2e-08", "provenance seed: - -> 2", "faces are the same"})
    CHECK_MESSAGE(contains(run.out, part), run.out);
  const Json json = diff_of(before, now, 0);
  CHECK(json.at("equal") == true);
  CHECK(json.at("controls").empty());
  CHECK(json.at("regions").empty());
  CHECK(json.at("random").at("frames") == 256);
  CHECK(json.at("random").at("max") == 0);
  CHECK(json.at("certificate").at("dependency.mse").at("now") == 2e-8);
}

TEST_CASE("controls and meshes that differ are named") {
  const ScratchFolder folder;
  const std::string before = folder / "before.fbk", now = folder / "now.fbk";
  const fb::PackedModel model = fb::tiny_packed_model();
  write(before, model);
  fb::PackedModel renamed = model;
  renamed.schema.controls[0].name = "jaw_drop";
  renamed.schema.controls[1].group = "elsewhere";
  write(now, renamed);
  const Json json = diff_of(before, now, 1);
  CHECK(json.at("equal") == false);
  CHECK(json.at("controls_added") == Json{"jaw_drop"});
  CHECK(json.at("controls_removed") == Json{model.schema.controls[0].name});
  REQUIRE(json.at("controls").size() == 1);
  CHECK(json.at("controls").at(0).at("name") == model.schema.controls[1].name);
  CHECK(json.at("controls").at(0).at("declared").at("now").at("group") == "elsewhere");
  const ToolRun run = run_tool({"diff", before, now});
  CHECK_MESSAGE(is_error_line(run.err, "diff", {"the faces differ"}), run.err);
  CHECK(contains(run.out, "control added: jaw_drop"));
  CHECK(run_tool({"diff", before, now, "--tolerance", "1"}).exit_code == 1);
}

TEST_CASE("where another mesh has other vertices, poses are not compared") {
  const ScratchFolder folder;
  const std::string toy = folder / "toy.fbk", tiny = folder / "tiny.fbk";
  write_tiny_archive(tiny);
  REQUIRE(run_tool({"bake", FB_TOY_RIG, "--out", toy, "--recipe", "linear", "--poses", "60"}).exit_code == 0);
  const Json json = diff_of(tiny, toy, 1);
  CHECK(json.at("vertices").at("now") == 50);
  CHECK(json.at("rest").is_null());
  CHECK(json.at("random").is_null());
  CHECK(contains(run_tool({"diff", tiny, toy}).out, "poses of different meshes are not compared"));
}

TEST_CASE("a control that moves the face otherwise is named first, with its vertex, place and distance") {
  const ScratchFolder folder;
  const std::string before = folder / "before.fbk", now = folder / "now.fbk";
  const auto bake_rig = [&](const char* rig, const std::string& out) {
    ToolSetting setting;
    setting.environment = {"FB_FAULT=other shape"};
    return run_tool({"bake", rig, "--recipe", "linear", "--poses", "60", "--out", out}, setting).exit_code;
  };
  REQUIRE(bake_rig(FB_TOY_RIG, before) == 0);
  REQUIRE(bake_rig(FB_FAULTY_RIG, now) == 0);
  const Json json = diff_of(before, now, 1);
  REQUIRE(json.at("controls").size() >= 1);
  const Json& first = json.at("controls").at(0);
  CHECK(first.at("name") == "browTwist");
  CHECK(first.at("vertex") == 0);
  CHECK(first.at("distance").get<double>() == doctest::Approx(1).epsilon(0.05));
  CHECK(first.at("max").get<double>() * json.at("diagonal").get<double>() == first.at("distance").get<double>());
  CHECK(first.at("place") != "");
  CHECK(json.at("rest").at("max") == 0);
  CHECK(json.at("random").at("vertex") == 0);
  const ToolRun run = run_tool({"diff", before, now});
  CHECK(contains(run.out, "browTwist at "));
  CHECK(run_tool({"diff", before, now, "--tolerance", "0.5"}).exit_code == 0);
}

TEST_CASE("driven joints that are others are named, and their motion is compared") {
  const ScratchFolder folder;
  const std::string before = folder / "before.fbk", now = folder / "now.fbk";
  const fb::PackedModel model = fb::driven_model();
  write(before, model);
  CHECK(run_tool({"diff", before, before}).exit_code == 0);
  const auto changed = [&](const fb::PackedModel& face, const std::string& words) {
    write(now, face);
    CHECK_MESSAGE(diff_of(before, now, 1).at("equal") == false, words);
    const ToolRun run = run_tool({"diff", before, now, "--tolerance", "1"});
    CHECK_MESSAGE(contains(run.out, words), run.out);
    CHECK_MESSAGE(run.exit_code == (words.empty() ? 0 : 1), run.out);
  };
  fb::PackedModel renamed = model, reached = model, followed = model, stronger = model;
  renamed.rest.driven.joints[1].name = "tongue tip";
  changed(renamed, "1 driven joints are gone: \"tongue\"\n1 driven joints are new: \"tongue tip\"\n");
  reached.rest.driven.joints[2].parent = 1;
  changed(reached, "1 driven joints have another parent, other numbers or another frame at rest: \"pin\"\n");
  followed.rest.driven.skin.weights[3 * 7] /= 2;
  changed(followed, "vertices follow other driven joints, or by other weights\n");
  stronger.rest.driven.scales[0] *= 1.5f;
  changed(stronger, "");
  fb::PackedModel more = model;
  fb::add_turning_joints(more);
  changed(more, "3 driven joints are new: \"eye\", \"brow\", \"ear\"\n");
  changed(fb::character_model(), "4 driven joints are gone: \"jaw\", \"tongue\", \"pin\", ...\n");
  // Those that are new have points behind the others that carry their numbers.
  write(before, fb::character_model());
  changed(model, "4 driven joints are new: ");
  CHECK(diff_of(before, now, 1).at("rest").at("max") == 0);
  // As many numbers, of other rotations.
  fb::PackedModel turning = more;
  std::swap(turning.rest.driven.joints[4].outer_rotations[0], turning.rest.driven.joints[4].outer_rotations[1]);
  write(before, more);
  changed(turning, "1 driven joints have another parent, other numbers or another frame at rest: \"eye\"\n");
}

TEST_CASE("a face with driven joints that is packed again poses as before, or as coarsely as is asked for") {
  const ScratchFolder folder;
  const std::string face = folder / "face.fbk", packed = folder / "packed.fbk";
  for (const fb::PackedModel& model : {fb::whole_model(), fb::driven_model()}) {
    write(face, model);
    REQUIRE(run_tool({"pack", face, "--out", packed}).exit_code == 0);
    CHECK(diff_of(face, packed, 0).at("equal") == true);
  }
  REQUIRE(run_tool({"pack", face, "--out", packed, "--max-error", "0.01"}).exit_code == 0);
  CHECK(run_tool({"verify", packed}).exit_code == 0);
  const Json coarser = diff_of(face, packed, 1);
  CHECK(coarser.at("schema").empty());
  CHECK(coarser.at("random").at("max") > 0);
}

}  // namespace test_tool_diff
