// However pack ends, the output file is the old one or the complete new one. tests/faults does more of this.
#include <doctest/doctest.h>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_faults {

namespace {

using Bytes = std::vector<std::byte>;

// A new folder below another, with a path of more than 900 bytes.
std::string deep_folder(const ScratchFolder& folder) {
  const std::string part(225, 'd');
  const std::string deep = folder / (part + "/" + part + "/" + part + "/" + part);
  fb::make_folder(deep);
  return deep + "/";
}

}  // namespace

TEST_CASE("on a full disk pack fails, leaving the old file and nothing else") {
  if (!can_limit_files) {
    MESSAGE("skipped: files cannot be limited in a build by clang");
    return;
  }
  const ScratchFolder folder;
  const std::string in = folder / "in.fbk", out = folder / "out.fbk";
  const fb::PackedModel model = fb::tiny_packed_model();
  fb::write_file(in, fb::archive::write_archive(model, fb::bake::make_proof(model, 1)));
  const Bytes old = fb::archive::write_archive(fb::tiny_packed_model(2), {});
  const std::size_t size = fb::read_file(in).size();
  for (const std::size_t room : {std::size_t(300), size / 2, size - 1}) {
    fb::write_file(out, old);
    ToolSetting setting;
    setting.largest_file = room;
    const ToolRun run = run_tool({"pack", in, "--out", out}, setting);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pack", {out, "writing failed"}));
    CHECK(fb::read_file(out) == old);
    CHECK(folder.names() == std::vector<std::string>{"in.fbk", "out.fbk"});
  }
}

TEST_CASE("a truncated file is refused, and partial files do not disturb packing") {
  const ScratchFolder folder;
  const std::string in = folder / "in.fbk", out = folder / "out.fbk";
  const fb::PackedModel model = fb::tiny_packed_model();
  const Bytes whole = fb::archive::write_archive(model, fb::bake::make_proof(model, 1));
  for (const std::size_t size : {std::size_t(0), std::size_t(100), whole.size() - 1}) {
    fb::write_file(in, std::span(whole).first(size));
    CHECK(run_tool({"verify", in}).exit_code == 1);
    CHECK(run_tool({"pack", in, "--out", out}).exit_code == 1);
    CHECK(!std::filesystem::exists(out));
  }
  fb::write_file(in, whole);
  fb::write_file(folder / "out.fbk.facebaker-partial", std::span(whole).first(10));
  CHECK(run_tool({"pack", in, "--out", out}).exit_code == 0);
  CHECK(fb::read_file(out) == whole);
}

TEST_CASE("a rig that throws or ends the program makes a bake fail with a message, and leaves no archive") {
  const struct {
    const char *fault, *word;
  } faults[] = {{"throws a number", "threw an exception"},    {"throws an exception", "the brow is missing"},
                {"throws when opened", "threw an exception"}, {"exits", "ended the program"},
                {"exits quickly", "ended the program"},       {"exits when opened", "ended the program"},
                {"far vertex", "vertex 17 x = 1e+10"}};
  for (const auto& wrong : faults) {
    CAPTURE(wrong.fault);
    const ScratchFolder folder;
    ToolSetting setting;
    setting.environment = {std::string("FB_FAULT=") + wrong.fault};
    const ToolRun run = run_tool(
        {"bake", FB_HOSTILE_RIG, "--out", folder / "out.fbk", "--poses", "200", "--recipe", "linear"}, setting);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(run.err.find("facebaker bake: ") != std::string::npos);
    CHECK(run.err.find(wrong.word) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder / "out.fbk"));
  }
}

TEST_CASE("messages about files with long paths give the reason and a part of the path") {
  const ScratchFolder folder;
  const std::string deep = deep_folder(folder), face = folder / "face.fbk", toy = FB_TOY_RIG, out = folder / "out.fbk";
  write_tiny_archive(face);
  for (const char* name :
       {"text.fbk", "text.npy", "text.so", "text.glb", "text.txt", "Text.FBX", "text.blend", "bad/dataset.json"}) {
    fb::make_folder(std::filesystem::path(deep + name).parent_path());
    fb::write_file(deep + name, std::string("no such thing"));
  }
  fb::make_folder(deep + "folder.fbk");
  const fb::OutputLock lock = fb::OutputLock::of_file(deep + "held.fbk");
  const struct {
    std::vector<std::string> arguments;
    const char* reason;
  } refused[] = {
      {{"pack", face, "--out", deep + "none/face.fbk"}, "cannot be written: No such file"},
      {{"pack", face, "--out", deep + "folder.fbk"}, "is a directory"},
      {{"pack", face, "--out", deep + "held.fbk"}, "is being written by process"},
      {{"pack", deep + "none.fbk", "--out", out}, "no such file"},
      {{"verify", deep + "text.fbk"}, "not an .fbk archive"},
      {{"inspect", deep}, "is a directory"},
      {{"bake", deep + "none", "--out", out}, "no such file or folder"},
      {{"bake", deep, "--out", out}, "is no dataset folder"},
      {{"bake", deep + "bad", "--out", out}, "is no JSON"},
      {{"bake", deep + "text.txt", "--out", out}, "neither a dataset folder"},
      {{"bake", deep + "Text.FBX", "--out", out}, "bake FILE --with-blender"},
      {{"bake", deep + "text.blend", "--out", out}, "a scene of Blender"},
      {{"bake", deep + "text.npy", "--out", out}, "positions without a rig"},
      {{"eval", face, deep + "text.fbk"}, "its source is the rig"},
      {{"eval", toy, deep + "text.fbk"}, "the archive comes first"},
      {{"bake", deep + "text.so", "--out", out}, "cannot be loaded as a rig plugin"},
      {{"bake", deep + "text.glb", "--out", out}, "is no whole glTF file"},
      {{"bake", toy, "--out", deep + "held.fbk"}, "is being written by process"},
      {{"sample", toy, "--out", deep + "text.txt"}, "cannot be created"},
      {{"sample", toy, "--out", out, "--clip", "a=" + deep + "text.npy"}, "is no NumPy array"},
      {{"eval", face, deep + "none"}, "no such file or folder"},
      {{"eval", face, toy, "--report", deep}, "holds something that is no report"},
      {{"pose", face, "--out", deep + "text.txt"}, "must end in"},
      {{"pose", face, "--out", deep + "none/face.obj"}, "cannot be written: No such file"},
      {{"pose", face, "--clip", deep + "text.npy", "--out", folder / "a.obj"}, "is no NumPy array"},
      {{"pose", face, "--beside", deep + "none", "--out", folder / "a.png"}, "no such file or folder"},
      {{"bench", face, "--csv", deep + "none/a.csv"}, "cannot be written: No such file"},
  };
  for (const auto& wrong : refused) {
    const ToolRun run = run_tool(wrong.arguments);
    CHECK(run.exit_code == 1);
    CHECK_MESSAGE(is_error_line(run.err, wrong.arguments[0], {wrong.reason, "..."}), run.err);
    CHECK_MESSAGE(run.err.size() < 900, run.err);
  }
}

}  // namespace test_tool_faults
