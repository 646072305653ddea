// Plans, their evaluation by another program, and checks of dataset folders, as a user meets them.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bake/dataset/npy.h"
#include "bake/dataset/open_source.h"
#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_datasets {

namespace {

using nlohmann::json;

json read_json(const std::string& path) {
  std::ifstream file(path);
  return json::parse(file);
}

std::string text_of(const std::string& path) {
  const auto bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

// Writes the points of a plan with the toy rig, but for its last `left_out` clips.
void evaluate_plan(const std::string& folder, std::size_t left_out) {
  const fb::bake::OpenedSource toy = fb::bake::open_source(FB_TOY_RIG);
  const std::size_t size = toy->rest().points.size();
  const json clips = read_json(folder + "/dataset.json").at("clips");
  for (std::size_t c = 0; c + left_out < clips.size(); ++c) {
    const fb::bake::NpyFile file(folder + "/" + clips[c].at("controls").get<std::string>());
    std::vector<float> controls(file.rows() * file.row_size()), points(file.rows() * size);
    file.read(0, file.rows(), controls);
    toy->evaluate(controls, file.rows(), points);
    fb::bake::write_npy(folder + "/" + clips[c].at("points").get<std::string>(), {file.rows(), size / 3, 3}, points);
  }
}

}  // namespace

TEST_CASE("a plan is evaluated, checked and baked") {
  const ScratchFolder folder;
  const std::string plan = folder / "plan", report = folder / "report";
  const ToolRun planned = run_tool({"plan", FB_TOY_RIG, "--poses", "100", "--no-shots", "--out", plan});
  CHECK_MESSAGE(planned.exit_code == 0, planned.err);
  CHECK_MESSAGE(has(planned.out, "121 poses to evaluate"), planned.out);

  const ToolRun waiting = run_tool({"check", plan, "--report", report});
  CHECK(waiting.exit_code == 1);
  CHECK_MESSAGE(has(waiting.err, "cannot be baked: 1 fault"), waiting.err);
  CHECK_MESSAGE(has(waiting.out, "fault: there is nothing to train on"), waiting.out);
  CHECK(has(text_of(report + "/index.html"), "Ranges used"));
  const ToolRun early = run_tool({"bake", plan, "--out", folder / "face.fbk"});
  CHECK(early.exit_code == 1);
  CHECK_MESSAGE(has(early.err, "no clip of the split train with points; they are missing for 121 of 121 poses"),
                early.err);

  evaluate_plan(plan, 1);
  const ToolRun part = run_tool({"bake", plan, "--recipe", "linear", "--out", folder / "face.fbk"});
  CHECK_MESSAGE(part.exit_code == 0, part.err);
  CHECK_MESSAGE(has(part.err, "8 of 121 poses, those of \"synthetic_shots\", are left out"), part.err);

  evaluate_plan(plan, 0);
  const ToolRun good = run_tool({"check", plan, "--json", folder / "check.json", "--report", report});
  CHECK_MESSAGE(good.exit_code == 0, good.err);
  CHECK(has(good.out, "The folder can be baked."));
  const json figures = read_json(folder / "check.json");
  CHECK(figures.at("bakeable") == true);
  CHECK(figures.at("faults").empty());
  CHECK(figures.at("evaluated") == 121);
  CHECK(figures.at("pairs").at("all") == 15);
  CHECK(figures.at("pairs").at("seen").get<int>() > 0);
  CHECK(figures.at("controls").at(0).at("highest").get<double>() > 0.5);
  const std::string page = text_of(report + "/index.html");
  for (const char* name : {"poses.png", "motion.png", "pairs.png"}) {
    CHECK(has(page, name));
    CHECK(std::filesystem::file_size(report + "/" + name) > 1000);
  }
  CHECK_FALSE(has(page, "<script"));
  const ToolRun baked = run_tool({"bake", plan, "--recipe", "linear", "--out", folder / "face.fbk"});
  CHECK_MESSAGE(baked.exit_code == 0, baked.err);
  CHECK(run_tool({"eval", folder / "face.fbk", FB_TOY_RIG}).exit_code == 0);
}

TEST_CASE("a plan needs a schema only, and is the same for a seed") {
  const ScratchFolder folder;
  const std::string schema = folder / "face.json";
  std::ofstream(schema) << R"({"format": "facebaker-dataset", "version": 1, "name": "f", "units": "cm", "up_axis": "y",
    "controls": [{"name": "a", "min": 0, "max": 1, "default": 0}, {"name": "b", "min": -1, "max": 1, "default": 0}]})";
  for (const char* out : {"one", "two"})
    CHECK(run_tool({"plan", schema, "--poses", "50", "--seed", "7", "--out", folder / out}).exit_code == 0);
  for (const auto& file : std::filesystem::directory_iterator(folder / "one")) {
    const std::string name = file.path().filename().string();
    if (file.is_regular_file() && !name.starts_with("."))
      CHECK(text_of(file.path()) == text_of(folder / "two/" + name));
  }
  CHECK(read_json(folder / "one/dataset.json").at("plan") == true);
  CHECK(run_tool({"plan", schema, "--poses", "50", "--seed", "8", "--out", folder / "one"}).exit_code == 1);
  const ToolRun figures = run_tool({"plan", schema, "--poses", "50", "--json", "--out", folder / "three"});
  CHECK(json::parse(figures.out).at("poses") == 61);
  CHECK(json::parse(figures.out).at("rest") == false);

  std::ofstream(schema) << "{}";
  const ToolRun wrong = run_tool({"plan", schema, "--out", folder / "four"});
  CHECK(wrong.exit_code == 1);
  CHECK(is_error_line(wrong.err, "plan", {"face.json", "format"}));
}

TEST_CASE("check goes on where a dataset is broken") {
  const ScratchFolder folder;
  const std::string broken = folder / "broken";
  std::filesystem::create_directory(broken);
  std::ofstream(broken + "/dataset.json")
      << R"({"format": "facebaker-dataset", "version": 1, "name": "f", "units": "cm",
    "up_axis": "up", "rest": "none.obj", "controls": [{"name": "a", "min": 1, "max": 1, "default": 1}, {"name": "b"}],
    "clips": [{"name": "c", "controls": "c.npy", "points": "p.npy"}]})";
  const ToolRun run = run_tool({"check", broken, "--report", folder / "report"});
  CHECK(run.exit_code == 1);
  for (const char* words : {"up_axis is neither", "none.obj", "control \"a\": minimum 1 is not below",
                            "controls[1] min is missing", "c.npy: no such file", "nothing to train on"}) {
    CHECK_MESSAGE(has(run.out, words), run.out);
  }
  CHECK(has(text_of(folder / "report/index.html"), "minimum 1 is not below"));
  CHECK(run_tool({"check", folder / "none"}).exit_code == 1);
}

}  // namespace test_tool_datasets
