// bake --with-blender, with a program in Blender's place that prints what it was called with.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_blender {

namespace {

// A folder with a program `blender`, and files to bake.
struct FakeBlender {
  ScratchFolder folder;

  FakeBlender() {
    const std::filesystem::path program = folder / "blender";
    std::ofstream(program) << "#!/bin/sh\nprintf '%s\\n' \"$@\" \"tool $FACEBAKER_TOOL\"\nexit 3\n";
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    for (const char* name : {"face.fbx", "face.blend"}) std::ofstream(folder / name) << "a file of another program";
  }

  ToolRun bake(std::vector<std::string> words) const {
    words.insert(words.begin(), "bake");
    return run_tool(words, {.environment = {"PATH=" + folder.path() + ":/usr/bin:/bin"}});
  }
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("Blender is called with the add-on, the file and all other options, and its exit code is the tool's") {
  const FakeBlender blender;
  const std::string fbx = blender.folder / "face.fbx", scene = blender.folder / "face.blend", out = "face.fbk";
  const ToolRun imported = blender.bake({fbx, "--with-blender", "--out", out, "--recipe", "compact", "--epochs=3"});
  CAPTURE(imported.err);
  CHECK(imported.exit_code == 3);
  const std::vector<std::string> lines = lines_of(imported.out);
  REQUIRE(lines.size() > 5);
  CHECK(lines[0] == "-b");
  CHECK(lines[4].ends_with("facebaker_blender/headless.py"));
  CHECK(std::filesystem::exists(lines[4]));
  CHECK(lines.back().ends_with("bin/facebaker"));
  const std::vector<std::string> words = {"--", "bake",     "--import", fbx,         "--out",
                                          out,  "--recipe", "compact",  "--epochs=3"};
  CHECK(std::vector<std::string>(lines.begin() + 5, lines.end() - 1) == words);

  const std::vector<std::string> of_scene = lines_of(blender.bake({"--with-blender", "--out", out, scene}).out);
  REQUIRE(of_scene.size() == 11);
  CHECK(of_scene[1] == scene);
  CHECK(std::vector<std::string>(of_scene.begin() + 6, of_scene.end() - 1) ==
        std::vector<std::string>{"--", "bake", "--out", out});
}

TEST_CASE("what is missing for a bake by Blender is named") {
  const FakeBlender blender;
  const std::string fbx = blender.folder / "face.fbx", out = blender.folder / "face.fbk";
  const ToolRun absent = blender.bake({blender.folder / "none.fbx", "--with-blender", "--out", out});
  CHECK(absent.exit_code == 1);
  CHECK(is_error_line(absent.err, "bake", {"none.fbx", "no such file"}));
  const ToolRun two = blender.bake({fbx, fbx, "--with-blender", "--out", out});
  CHECK(is_error_line(two.err, "bake", {"Blender bakes one file"}));
  std::filesystem::remove(blender.folder / "blender");
  const ToolRun none =
      run_tool({"bake", fbx, "--with-blender", "--out", out}, {.environment = {"PATH=" + blender.folder.path()}});
  CHECK(none.exit_code == 1);
  CHECK(is_error_line(none.err, "bake", {"there is no program blender in PATH"}));
  // Without the flag, the message says it.
  const ToolRun told = blender.bake({fbx, "--out", out});
  CHECK(is_error_line(told.err, "bake", {"face.fbx", "facebaker bake FILE --with-blender --out FACE.fbk"}));
}

}  // namespace test_tool_blender
