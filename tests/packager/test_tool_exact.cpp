// Poses that are kept exact: from bake and pack to inspect.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_exact {

using Json = nlohmann::ordered_json;

namespace {

Json output_of(const std::vector<std::string>& arguments) {
  const ToolRun run = run_tool(arguments);
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  return Json::parse(run.out);
}

}  // namespace

TEST_CASE("frames of a dataset are kept exact by bake and pack, and shown by inspect") {
  const ScratchFolder folder;
  const std::string dataset = folder / "toy", archive = folder / "toy.fbk", packed = folder / "packed.fbk";
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", dataset, "--poses", "60"}).exit_code == 0);
  const auto bytes = fb::read_file(dataset + "/dataset.json");
  const Json index = Json::parse(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const std::string clip = index.at("clips").back().at("name");
  const std::vector<std::string> bake = {"bake", dataset, "--out", archive, "--recipe", "linear"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), bake.begin(), bake.end());
    return more;
  };
  const Json baked = output_of(with({"--exact", clip + ":1,2", "--exact", clip + ":0", "--json"}));
  CHECK(baked.at("exact").at("frames") == 3);
  CHECK(baked.at("exact").at("max").get<double>() < 2e-6);
  const Json json = output_of({"inspect", archive, "--json"});
  REQUIRE(json.at("exact_poses").size() == 3);
  CHECK(json.at("exact_poses")[0].at("name") == clip + ":1");
  CHECK(json.at("certificate").at("exact").at("poses") == 3);
  REQUIRE(run_tool({"pack", archive, "--out", packed, "--max-error", "0.002"}).exit_code == 0);
  const Json certificate = output_of({"inspect", packed, "--json"}).at("certificate");
  CHECK(certificate.at("exact").at("max").get<double>() < 3e-6);
  CHECK(certificate.at("exact").at("max") > json.at("certificate").at("exact").at("max"));
  const std::string text = run_tool({"inspect", packed}).out;
  CHECK(text.find("| exact pose") != std::string::npos);
  CHECK(text.find("| " + clip + ":2 ") != std::string::npos);
  CHECK(text.find("| exact  ") != std::string::npos);
  CHECK(run_tool({"verify", packed}).exit_code == 0);

  CHECK(output_of(with({"--json"})).at("exact").is_null());
  CHECK(!output_of({"inspect", archive, "--json"}).contains("exact_poses"));
  const ToolRun unknown = run_tool(with({"--exact", clip + "x:1"}));
  CHECK(unknown.exit_code != 0);
  CHECK(unknown.err.find("the closest clip is \"" + clip + "\"") != std::string::npos);
}

}  // namespace test_tool_exact
