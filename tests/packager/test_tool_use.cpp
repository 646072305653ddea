// What every command has in common: help, wrong use, bad files, and a full disk.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <sstream>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_use {

namespace {

const std::vector<std::string> commands = {"sample",  "plan",    "check",  "bake",  "eval",
                                           "compare", "inspect", "verify", "bag",   "sign",
                                           "pose",    "export",  "header", "bench", "rig-host"};

}  // namespace

TEST_CASE("every command has help and every option a description") {
  const ToolRun overview = run_tool({"--help"});
  CHECK(overview.exit_code == 0);
  for (const std::string& command : commands) {
    CAPTURE(command);
    CHECK(overview.out.find("\n  " + command + " ") != std::string::npos);
    const ToolRun help = run_tool({command, "--help"});
    CHECK(help.exit_code == 0);
    CHECK(help.err.empty());
    CHECK(help.out.find("Usage: facebaker " + command) != std::string::npos);
    // A description begins in column 30, on the line of its option or the next.
    std::istringstream lines(help.out);
    std::vector<std::string> page;
    for (std::string line; std::getline(lines, line);) page.push_back(line);
    page.emplace_back();
    for (std::size_t i = 0; i + 1 < page.size(); ++i) {
      if (!page[i].starts_with("  -")) continue;
      CAPTURE(page[i]);
      const std::string& told = page[i].size() < 30 || page[i][29] != ' ' ? page[i + 1] : page[i];
      CHECK((&told == &page[i] || told.starts_with("                              ")));
      CHECK(told.find_first_not_of(' ', 30) == 30);
    }
  }
}

TEST_CASE("the version is printed") {
  const ToolRun run = run_tool({"--version"});
  CHECK(run.exit_code == 0);
  CHECK(run.out.starts_with("facebaker "));
}

TEST_CASE("threads wait without spinning unless the user wants them to") {
  const auto spins = [](const std::string& policy) {  // as GNU OpenMP tells
    std::vector<std::string> arguments = {"-u", "OMP_WAIT_POLICY", "OMP_DISPLAY_ENV=verbose"};
    if (!policy.empty()) arguments.push_back("OMP_WAIT_POLICY=" + policy);
    arguments.insert(arguments.end(), {FB_TOOL, "--version"});
    const std::string text = run_program("/usr/bin/env", arguments).err;
    const std::size_t last = text.rfind("GOMP_SPINCOUNT");
    return last == std::string::npos ? "" : text.substr(last, text.find('\n', last) - last);
  };
  if (spins("").empty()) {
    MESSAGE("skipped: not built with GNU OpenMP");
    return;
  }
  CHECK(spins("") == "GOMP_SPINCOUNT = '0'");
  CHECK(spins("ACTIVE") != "GOMP_SPINCOUNT = '0'");
}

TEST_CASE("wrong use exits with 2 and one line that mentions --help") {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"juggle"},
      {"pose"},
      {"inspect"},
      {"inspect", "a.fbk", "--frobnicate"},
      {"pose", "a.fbk"},
      {"sample", "sample"},
      {"sample", "sample", "--out", "x", "--mix", "thin"},
      {"sample", "sample", "--out", "x", "--poses", "0"},
      {"sample", "sample", "--out", "x", "--seed", "-1"},
      {"sample", "sample", "--out", "x", "--seed", "99999999999999999999"},
      {"bake", "sample", "--out", "x.fbk", "--epochs", "-1"},
      {"bake", "sample", "--out", "x.fbk", "--epochs", "99999999999"},
      {"pose", "a.fbk", "--out", "x.obj", "--threads", "-1"},
      {"pose", "a.fbk", "--out", "x.obj", "--frame", "two"},
      {"pose", "a.fbk", "--out", "x.obj", "--frame", "-1"}};
  for (const auto& arguments : wrong) {
    const ToolRun run = run_tool(arguments);
    CAPTURE(run.err);
    CHECK(run.exit_code == 2);
    CHECK(run.out.empty());
    CHECK(run.err.starts_with("facebaker"));
    CHECK(run.err.ends_with("(see --help)\n"));
    CHECK(run.err.size() < 200);
  }
}

TEST_CASE("files that are no archives are refused by name, whatever the command") {
  const ScratchFolder folder;
  const std::string good = folder / "good.fbk", missing = folder / "missing.fbk", foreign = folder / "foreign.fbk",
                    cut = folder / "cut.fbk", flipped = folder / "flipped.fbk", empty = folder / "empty.fbk",
                    newer = folder / "newer.fbk";
  write_tiny_archive(good);
  auto bytes = fb::read_file(good);
  fb::write_file(foreign, std::string("PK\3\4 this is something else altogether, as long as a header is"));
  fb::write_file(empty, std::string());
  fb::write_file(cut, std::span(bytes).first(bytes.size() - 9));
  bytes[bytes.size() / 2] ^= std::byte{4};
  fb::write_file(flipped, bytes);
  bytes[8] = std::byte{9};  // the major version
  fb::write_file(newer, bytes);
  const auto before = folder.names();
  for (const std::string& archive : {missing, folder.path(), foreign, cut, flipped, empty, newer}) {
    for (const auto& arguments :
         std::vector<std::vector<std::string>>{{"inspect", archive},
                                               {"inspect", archive, "--json"},
                                               {"verify", archive},
                                               {"eval", archive, FB_TOY_RIG, "--json", folder / "x.json"},
                                               {"pose", archive, "--out", folder / "x.png"},
                                               {"export", archive, folder / "x.onnx"}}) {
      const ToolRun run = run_tool(arguments);
      CAPTURE(run.err);
      CHECK(run.exit_code == 1);
      CHECK(run.out.empty());
      CHECK(is_error_line(run.err, arguments[0], {archive}));
    }
  }
  CHECK(is_error_line(run_tool({"inspect", missing}).err, "inspect", {missing, "no such file"}));
  CHECK(is_error_line(run_tool({"inspect", folder.path()}).err, "inspect", {folder.path(), "directory"}));
  CHECK(is_error_line(run_tool({"verify", newer}).err, "verify", {"version", "9"}));
  CHECK(folder.names() == before);
}

TEST_CASE("an output folder that does not exist is refused and leaves nothing") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  write_tiny_archive(archive);
  for (const char* ending : {".png", ".obj", ".glb"}) {
    const std::string nowhere = folder / (std::string("no/such/folder/x") + ending);
    const ToolRun run = run_tool({"pose", archive, "--out", nowhere});
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pose", {nowhere, "cannot be written"}));
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  }
  for (const char* ending : {".glb", ".onnx", ".usda"}) {
    const std::string nowhere = folder / (std::string("no/such/folder/x") + ending);
    CHECK(is_error_line(run_tool({"export", archive, nowhere}).err, "export", {nowhere, "cannot be written"}));
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  }
}

TEST_CASE("a pipe or device is not replaced by a file") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", pipe = folder / "pipe.obj";
  write_tiny_archive(archive);
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const ToolRun run = run_tool({"pose", archive, "--out", pipe});
  CHECK(run.exit_code == 1);
  CHECK(is_error_line(run.err, "pose", {pipe, "not a regular file"}));
  CHECK(std::filesystem::is_fifo(pipe));
}

TEST_CASE("a disk that fills up leaves the old file and no partial one") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  write_tiny_archive(archive);
  if (!can_limit_files) MESSAGE("skipped in part: files cannot be limited in a build by clang");
  for (const char* ending : {".png", ".obj", ".glb"}) {
    if (!can_limit_files) break;
    const std::string out = folder / (std::string("pose") + ending);
    fb::write_file(out, std::string("precious"));
    ToolSetting full;
    full.largest_file = 100;
    const ToolRun run = run_tool({"pose", archive, "--out", out}, full);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pose", {out, "writing failed"}));
    const auto kept = fb::read_file(out);
    CHECK(std::string(reinterpret_cast<const char*>(kept.data()), kept.size()) == "precious");
    std::filesystem::remove(out);
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  }
  if (std::filesystem::is_character_file("/dev/full")) {
    const ToolRun run = run_tool({"inspect", archive, "--json"}, {.standard_output = "/dev/full"});
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "inspect", {"standard output"}));
  }
}

}  // namespace test_tool_use
