// A list of characters, as a user of the tool bakes it.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_farm {

namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The line of a table that begins with a name.
std::string row_of(const std::string& table, const std::string& name) {
  const std::size_t begin = table.find("| " + name + " ");
  return begin == std::string::npos ? "" : table.substr(begin, table.find('\n', begin) - begin);
}

constexpr const char* quick = " --recipe linear --poses 60 --use variant --epochs 1\n";

ToolRun farm(const ScratchFolder& folder, const std::vector<std::string>& more, const ToolSetting& setting = {}) {
  std::vector<std::string> arguments = {"farm", folder / "list.txt", "--out", folder / "faces"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_tool(arguments, setting);
}

}  // namespace

TEST_CASE("a farm bakes every character, tells which failed and why, and goes on with these") {
  const ScratchFolder folder;
  const std::string good = std::string(FB_TOY_RIG) + quick;
  fb::write_file(folder / "list.txt", "# two that bake, and one that does not\n" + good + "\n'second'=" + good +
                                          "bad=" + (folder / "missing.so") + quick);
  const ToolRun before = farm(folder, {"--status"});
  CHECK(before.exit_code == 1);
  CHECK(contains(row_of(before.out, "toy"), "waiting"));
  CHECK_FALSE(std::filesystem::exists(folder / "faces"));

  const ToolRun first = farm(folder, {"--jobs", "2"});
  CHECK(first.exit_code == 1);
  CHECK_MESSAGE(is_error_line(first.err.substr(first.err.rfind("facebaker farm")), "farm", {"1 of 3"}), first.err);
  CHECK_MESSAGE(contains(row_of(first.out, "toy"), "done"), first.out);
  CHECK(contains(row_of(first.out, "toy"), std::to_string(std::filesystem::file_size(folder / "faces/toy.fbk"))));
  CHECK(contains(row_of(first.out, "second"), "done"));
  CHECK(contains(row_of(first.out, "bad"), "failed"));
  CHECK_MESSAGE(contains(row_of(first.out, "bad"), "missing.so"), first.out);
  CHECK(contains(text_of(folder / "faces/toy.log"), "facebaker bake " FB_TOY_RIG " --recipe linear"));

  // The archive is that of the command alone.
  const ToolRun alone = run_tool({"bake", FB_TOY_RIG, "--recipe", "linear", "--poses", "60", "--use", "variant",
                                  "--epochs", "1", "--out", folder / "alone.fbk"});
  REQUIRE_MESSAGE(alone.exit_code == 0, alone.err);
  CHECK(fb::read_file(folder / "alone.fbk") == fb::read_file(folder / "faces/toy.fbk"));

  // What is done stays; the other is tried again.
  const auto time = std::filesystem::last_write_time(folder / "faces/toy.log");
  fb::write_file(folder / "list.txt", good + "second=" + good + "bad=" + good);
  const ToolRun second = farm(folder, {});
  CHECK_MESSAGE(second.exit_code == 0, second.err);
  CHECK(contains(row_of(second.out, "bad"), "done"));
  CHECK_FALSE(contains(second.err, "toy: begun"));
  CHECK(std::filesystem::last_write_time(folder / "faces/toy.log") == time);
  CHECK(farm(folder, {"--status"}).exit_code == 0);

  // Other options are another character.
  fb::write_file(folder / "list.txt", good + "second=" + std::string(FB_TOY_RIG) + " --recipe linear --poses 61\n");
  const ToolRun other = farm(folder, {"--status"});
  CHECK(other.exit_code == 1);
  CHECK(contains(row_of(other.out, "toy"), "done"));
  CHECK(contains(row_of(other.out, "second"), "waiting"));
}

TEST_CASE("--only bakes some of the list") {
  const ScratchFolder folder;
  fb::write_file(folder / "list.txt", "a=" + std::string(FB_TOY_RIG) + quick + "b=" + FB_TOY_RIG + quick);
  const ToolRun one = farm(folder, {"--only", "b"});
  CHECK_MESSAGE(one.exit_code == 0, one.err);
  CHECK_FALSE(std::filesystem::exists(folder / "faces/a.fbk"));
  const ToolRun unknown = farm(folder, {"--only", "c"});
  CHECK(unknown.exit_code == 1);
  CHECK(is_error_line(unknown.err, "farm", {"no character \"c\""}));
}

TEST_CASE("an interrupted farm stops its bakes, which go on next time") {
  const ScratchFolder folder;
  fb::write_file(folder / "list.txt",
                 "slow=" + std::string(FB_FAULTY_RIG) + " --recipe linear --poses 400 --use variant\n");
  ToolSetting setting;
  setting.environment = {"FB_FAULT=sleeps"};
  setting.interrupt_when_exists = folder / "faces/slow.fbk.work/rig.evaluations";
  const ToolRun stopped = farm(folder, {}, setting);
  CHECK(stopped.exit_code == 1);
  CHECK_MESSAGE(contains(row_of(stopped.out, "slow"), "stopped"), (stopped.out + stopped.err));
  CHECK(contains(text_of(folder / "faces/slow.log"), "interrupted; what is done is kept"));
  setting.interrupt_when_exists.clear();
  setting.environment = {"FB_FAULT="};
  const ToolRun going_on = farm(folder, {}, setting);
  CHECK_MESSAGE(going_on.exit_code == 0, (going_on.out + going_on.err));
  CHECK_FALSE(std::filesystem::exists(folder / "faces/slow.fbk.work"));
}

TEST_CASE("a list that cannot be is refused by its line") {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& text, const std::string& words) {
    fb::write_file(folder / "list.txt", text);
    const ToolRun refused = farm(folder, {});
    CHECK(refused.exit_code == 1);
    CHECK_MESSAGE(is_error_line(refused.err, "farm", {words}), refused.err);
    CHECK_FALSE(std::filesystem::exists(folder / "faces"));
  };
  refusal("# nothing\n\n", "no characters");
  refusal("a.so\nb=sample\nx/librig_a.so\n", "line 3: \"a\" is the name of line 1 too");
  refusal("sample --out here.fbk\n", "line 1: --out");
  refusal("\nexec:'python3 rig.py'\n", "line 2: a command needs a name");
  refusal("sample 'unclosed\n", "line 1: a quote is not closed");
  refusal("sample; rm -rf /\n", "line 1: one of |&;<>(){} has to be in quotes");
  refusal("sample $(ls)\n", "line 1: $(...)");
  refusal("--recipe hero\n", "line 1: begins with the option --recipe");
  refusal("hero=\n", "line 1: no source after \"hero=\"");
  CHECK(is_error_line(run_tool({"farm", folder / "none.txt", "--out", folder / "faces"}).err, "farm", {"none.txt"}));
  CHECK(run_tool({"farm", folder / "list.txt", "--out", folder / "faces", "--sbatch", "--time=1"}).exit_code == 2);
}

TEST_CASE("names and options are read as in a shell, and # begins a comment only as a word") {
  const ScratchFolder folder;
  fb::write_file(folder / "list.txt",
                 "sample --licence \"a # b.txt\"  # it's a comment\nx#y=sample\n./heads/hero.v2.glb # 'quoted\n");
  const ToolRun status = farm(folder, {"--status"});
  CHECK_MESSAGE(is_error_line(status.err, "farm", {"line 2", "cannot be a name"}), status.err);
  fb::write_file(folder / "list.txt",
                 "sample --licence \"a # b.txt\"  # it's a comment\n./heads/hero.v2.glb # 'quoted\n");
  const ToolRun good = farm(folder, {"--status"});
  CHECK_MESSAGE(contains(row_of(good.out, "hero.v2"), "waiting"), (good.out + good.err));
  CHECK(contains(row_of(good.out, "sample"), "waiting"));
}

}  // namespace test_tool_farm
