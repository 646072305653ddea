// Bags as the tool writes and checks them.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace fs = std::filesystem;

namespace test_tool_bag {

using Json = nlohmann::json;

namespace {

// Without the lines of stages before it, which are there where they take long.
std::string last_line(const std::string& err) {
  const std::size_t end = err.size() > 1 ? err.rfind('\n', err.size() - 2) : err.npos;
  return end == err.npos ? err : err.substr(end + 1);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string text_of(const std::string& file) {
  const std::vector<std::byte> bytes = fb::read_file(file);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_face(const std::string& path, std::uint64_t seed) {
  const fb::PackedModel model = fb::tiny_packed_model(seed);
  fb::write_file(path, fb::archive::write_archive(model, fb::bake::make_proof(model, 1)));
}

}  // namespace

TEST_CASE("a bag is written with access copies, and is whole") {
  const ScratchFolder folder;
  write_face(folder / "king.fbk", 1);
  write_face(folder / "queen.fbk", 2);
  fb::write_file(folder / "king.fbk.sig", std::string("signature"));
  fs::create_directory(folder / "rig");
  fb::write_file(folder / "rig/dataset.json", std::string("{}"));
  const std::vector<std::string> arguments = {"bag",
                                              folder / "king.fbk",
                                              folder / "queen.fbk",
                                              "--signature",
                                              folder / "king.fbk.sig",
                                              "--source",
                                              folder / "rig",
                                              "--date",
                                              "2026-11-29",
                                              "--organisation",
                                              "An archive",
                                              "--identifier",
                                              "17/4",
                                              "--info",
                                              "Contact-Name: A. Keeper",
                                              "--out"};
  std::vector<std::string> first = arguments, second = arguments;
  first.push_back(folder / "bag");
  second.push_back(folder / "again");
  const ToolRun run = run_tool(first);
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  CHECK(contains(run.out, "whole; 2 archives evaluate as archived, bit for bit"));
  for (const char* file :
       {"archives/king.fbk", "archives/king.fbk.sig", "archives/queen.fbk", "access/king.fbk.png",
        "access/king.fbk.glb", "access/queen.fbk.txt", "source/rig/dataset.json", "metadata/premis.xml",
        "metadata/king.fbk.rights.txt", "texts/FORMAT.md", "reader/fbk_read.py", "README.txt"})
    CHECK_MESSAGE(fs::exists(folder / (std::string("bag/data/") + file)), file);
  const std::string info = text_of(folder / "bag/bag-info.txt");
  for (const char* line : {"Bagging-Date: 2026-11-29\n", "Source-Organization: An archive\n",
                           "External-Identifier: 17/4\n", "Contact-Name: A. Keeper\n"})
    CHECK_MESSAGE(contains(info, line), info);
  REQUIRE(run_tool(second).exit_code == 0);
  CHECK(text_of(folder / "bag/tagmanifest-sha512.txt") == text_of(folder / "again/tagmanifest-sha512.txt"));
  CHECK(folder.names() == std::vector<std::string>{"again", "bag", "king.fbk", "king.fbk.sig", "queen.fbk", "rig"});

  const Json json = Json::parse(run_tool({"bag", "--check", folder / "bag", "--json"}).out);
  CHECK(json.at("valid") == true);
  CHECK(json.at("version") == "1.0");
  CHECK(json.at("archives").size() == 2);
  CHECK(json.at("archives")[0].at("file") == "data/archives/king.fbk");
  CHECK(json.at("faults").empty());
  CHECK(json.at("warnings").empty());
}

TEST_CASE("faults of a bag are all printed, and the exit code is 1") {
  const ScratchFolder folder;
  write_face(folder / "king.fbk", 1);
  REQUIRE(run_tool({"bag", folder / "king.fbk", "--out", folder / "bag"}).exit_code == 0);
  fb::write_file(folder / "bag/data/more\n.txt", std::string("more"));
  fs::remove(folder / "bag/data/README.txt");
  const ToolRun run = run_tool({"bag", "--check", folder / "bag"});
  CHECK(run.exit_code == 1);
  CHECK(contains(run.out, "data/README.txt: is missing; manifest-sha512.txt names it\n"));
  CHECK(contains(run.out, "data/more\\u000a.txt: manifest-sha512.txt does not name it\n"));
  CHECK_MESSAGE(contains(run.err, "facebaker bag: " + (folder / "bag") + ": is no valid bag: 3 faults\n"), run.err);
  const ToolRun json = run_tool({"bag", "--check", folder / "bag", "--json"});
  CHECK(json.exit_code == 1);
  CHECK(Json::parse(json.out).at("valid") == false);
}

TEST_CASE("what the command is not given is named") {
  const ScratchFolder folder;
  write_face(folder / "king.fbk", 1);
  const std::string face = folder / "king.fbk", bag = folder / "bag";
  const auto fails = [&](const std::vector<std::string>& arguments, const std::string& part) {
    const ToolRun run = run_tool(arguments);
    CHECK(run.exit_code == 1);
    CHECK_MESSAGE(is_error_line(last_line(run.err), "bag", {part}), run.err);
    CHECK(folder.names() == std::vector<std::string>{"king.fbk"});
  };
  fails({"bag"}, "give archives to put into a bag, or --check DIR");
  fails({"bag", face}, "give --out DIR");
  fails({"bag", face, "--check", bag}, "has no effect with --check");
  fails({"bag", "--check", bag}, "no such folder");
  fails({"bag", face, face, "--out", bag}, "would both be data/archives/king.fbk in the bag");
  fails({"bag", face, "--out", bag, "--date", "29.11.2026"}, "give a day as 2026-11-29");
  fails({"bag", face, "--out", bag, "--info", "nothing"}, "give \"Label: value\"");
  fails({"bag", face, "--out", bag, "--source", folder / "none"}, "no such file");
  fails({"bag", face, "--out", face}, "is there, and is no folder");
}

TEST_CASE("a bag that is interrupted is not there") {
  const ScratchFolder folder;
  std::vector<std::string> arguments = {"bag"};
  for (int i = 0; i < 20; ++i) {
    const std::string face = folder / ("face" + std::to_string(i) + ".fbk");
    write_face(face, static_cast<std::uint64_t>(i));
    arguments.push_back(face);
  }
  arguments.insert(arguments.end(), {"--out", folder / "bag", "--date", "2026-11-29"});
  ToolSetting setting;
  setting.interrupt_when_exists = folder / "bag.facebaker-partial/data/archives/face1.fbk";
  for (const int signal : {SIGINT, SIGKILL}) {
    setting.signal = signal;
    const ToolRun run = run_tool(arguments, setting);
    CHECK(run.exit_code == (signal == SIGKILL ? 128 + SIGKILL : 1));
    CHECK(!fs::exists(folder / "bag"));
    CHECK(fs::exists(folder / "bag.facebaker-partial") == (signal == SIGKILL));
  }
  REQUIRE(run_tool(arguments).exit_code == 0);
  CHECK(run_tool({"bag", "--check", folder / "bag"}).exit_code == 0);
  CHECK(folder.names().size() == 21);
}

}  // namespace test_tool_bag
