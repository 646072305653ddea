// However pack ends, the output file is the old one or the complete new one. tests/faults does more of this.
#include <doctest/doctest.h>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace {

using Bytes = std::vector<std::byte>;

}  // namespace

TEST_CASE("on a full disk pack fails, leaving the old file and nothing else") {
  if (!can_limit_files) return;
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
