// Levels of detail through the command line: bake, inspect, verify, pose, and meshes that are given.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_levels {

using Json = nlohmann::json;

namespace {

ToolRun ran(const std::vector<std::string>& arguments) {
  const ToolRun run = run_tool(arguments);
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  return run;
}

void bake(const std::string& source, const std::string& out, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"bake", source, "--out", out, "--recipe", "compact", "--epochs", "2"});
  ran(options);
}

std::size_t lines_of(const std::string& path, const std::string& kind) {
  const auto bytes = fb::read_file(path);
  std::string text = "\n" + std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find("\n" + kind + " ", at)) != std::string::npos; ++at) ++count;
  return count;
}

}  // namespace

TEST_CASE("a face with three levels is baked, told about, proven and posed") {
  const ScratchFolder folder;
  const std::string data = folder / "toy", plain = folder / "plain.fbk", face = folder / "face.fbk";
  ran({"sample", FB_TOY_RIG, "--out", data, "--poses", "200"});
  bake(data, plain);
  bake(data, face, {"--levels", "3"});
  MESSAGE("levels take " << double(std::filesystem::file_size(face)) / double(std::filesystem::file_size(plain))
                         << " times the bytes");
  ran({"verify", face});
  const fb::archive::Archive read = fb::archive::read_archive(fb::read_file(face));
  REQUIRE(read.model.levels.size() == 2);
  CHECK(read.model.levels[0].vertices < read.model.rest.vertex_count());
  CHECK(read.model.levels[1].vertices < read.model.levels[0].vertices);
  CHECK(fb::archive::read_archive(fb::read_file(plain)).model.levels.empty());

  const Json document = Json::parse(ran({"inspect", face, "--json"}).out);
  REQUIRE(document.at("levels").size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(document.at("levels")[k].at("vertices") == read.model.levels[k].vertices);
    const Json& certified = document.at("certificate").at("levels").at(k);
    CHECK(certified.at("vertices") == read.model.levels[k].vertices);
    CHECK(certified.at("rms").get<double>() > 0);
    CHECK(certified.at("rms").get<double>() <= certified.at("max").get<double>());
    CHECK(certified.at("surface").at("max").get<double>() > 0);
    CHECK(certified.at("frames").get<std::size_t>() > 0);
  }
  const std::string text = ran({"inspect", face}).out;
  CHECK(text.find("level of detail 2") != std::string::npos);
  CHECK(!Json::parse(ran({"inspect", plain, "--json"}).out).contains("levels"));

  const std::string whole = folder / "whole.obj", coarse = folder / "coarse.obj", between = folder / "between.obj";
  ran({"pose", face, "--out", whole});
  ran({"pose", face, "--out", coarse, "--lod", "1"});
  ran({"pose", face, "--out", between, "--lod", "1.5"});
  CHECK(lines_of(coarse, "v") == lines_of(whole, "v"));
  CHECK(lines_of(coarse, "f") == read.model.levels[0].polygon_sizes.size());
  CHECK(lines_of(between, "f") == lines_of(coarse, "f"));
  ran({"pose", face, "--out", folder / "coarse.png", "--lod", "2", "--size", "64x64"});
  const ToolRun refused = run_tool({"pose", face, "--out", folder / "coarse.glb", "--lod", "1"});
  CHECK(refused.exit_code != 0);
  CHECK(refused.err.find("--lod needs") != std::string::npos);

  // The mesh of a level, given for another bake: the same polygons.
  const std::string given = folder / "given.fbk";
  bake(data, given, {"--level-mesh", coarse});
  const fb::archive::Archive again = fb::archive::read_archive(fb::read_file(given));
  REQUIRE(again.model.levels.size() == 1);
  CHECK(again.model.levels[0].vertices == read.model.levels[0].vertices);
  CHECK(again.model.levels[0].polygon_corners == read.model.levels[0].polygon_corners);
  ran({"verify", given});
}

TEST_CASE("levels that cannot be baked are refused with a reason") {
  const ScratchFolder folder;
  const std::string data = folder / "toy", out = folder / "face.fbk", mesh = folder / "far.obj";
  ran({"sample", FB_TOY_RIG, "--out", data, "--poses", "60"});
  const auto refused = [&](const std::vector<std::string>& options, const char* reason) {
    std::vector<std::string> arguments = {"bake", data, "--out", out, "--epochs", "1"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ToolRun run = run_tool(arguments);
    CHECK(run.exit_code != 0);
    CHECK_MESSAGE(run.err.find(reason) != std::string::npos, run.err);
    CHECK(!std::filesystem::exists(out));
  };
  refused({"--recipe", "paper", "--levels", "2"}, "does not support levels of detail");
  refused({"--recipe", "linear", "--level-shares", "0.5,0.7"}, "shares are between 0 and 1 and fall");
  refused({"--levels", "1"}, "--levels");
  fb::write_file(mesh, std::string("v 0.123 4.5 6.78\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  refused({"--recipe", "linear", "--level-mesh", mesh}, "vertex 0 at (0.123, 4.5, 6.78) is no vertex");
}

}  // namespace test_tool_levels
