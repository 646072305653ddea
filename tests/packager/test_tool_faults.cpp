// However and whenever bake or pack ends, the output file is the old one or the complete new one.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace {

using Bytes = std::vector<std::byte>;

constexpr int kills = 12;

// Runs the tool with these arguments, which write `out`, killed at `kills` moments spread over its run time; out
// is `old` before each. Returns how often the new file was complete.
int kill_at_all_moments(const std::vector<std::string>& arguments, const std::string& out, const Bytes& old,
                        const Bytes& fresh) {
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(run_tool(arguments).exit_code == 0);
  REQUIRE(fb::read_file(out) == fresh);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  int whole = 0;
  for (int k = 0; k < kills; ++k) {
    fb::write_file(out, old);
    ToolSetting setting;
    setting.kill_after_ms = static_cast<int>(1200 * seconds * k / kills);
    run_tool(arguments, setting);
    const Bytes now = fb::read_file(out);
    CHECK((now == old || now == fresh));
    whole += now == fresh;
  }
  REQUIRE(run_tool(arguments).exit_code == 0);  // files left behind do not disturb
  CHECK(fb::read_file(out) == fresh);
  return whole;
}

}  // namespace

TEST_CASE("pack killed at any moment leaves the old file or the new one") {
  const ScratchFolder folder;
  const std::string in = folder / "in.fbk", out = folder / "out.fbk";
  fb::PackedModel model = fb::tiny_packed_model();
  fb::write_file(in, fb::archive::write_archive(model, fb::bake::make_proof(model, 1)));
  model.schema.name = "old";
  const Bytes old = fb::archive::write_archive(model, {});
  CHECK(kill_at_all_moments({"pack", in, "--out", out}, out, old, fb::read_file(in)) < kills);
}

TEST_CASE("bake killed at any moment leaves the old file, and continues to the same bytes") {
  const ScratchFolder folder;
  const std::string out = folder / "out.fbk", first = folder / "first.fbk";
  const auto bake = [&](const std::string& to, const std::string& work) {
    return std::vector<std::string>{"bake",     FB_TOY_RIG, "--out",    to,       "--poses", "100",
                                    "--epochs", "2",        "--recipe", "linear", "--work",  work};
  };
  REQUIRE(run_tool(bake(first, folder / "work-1")).exit_code == 0);
  const Bytes old = fb::archive::write_archive(fb::tiny_packed_model(), {});
  CHECK(kill_at_all_moments(bake(out, folder / "work-2"), out, old, fb::read_file(first)) < kills);
}

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
  fb::write_file(folder / "out.fbk.partial-1", std::span(whole).first(10));
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
    setting.environment = std::string("FB_FAULT=") + wrong.fault;
    const ToolRun run = run_tool(
        {"bake", FB_HOSTILE_RIG, "--out", folder / "out.fbk", "--poses", "200", "--recipe", "linear"}, setting);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(run.err.find("facebaker bake: ") != std::string::npos);
    CHECK(run.err.find(wrong.word) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder / "out.fbk"));
  }
}
