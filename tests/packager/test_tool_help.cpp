// Help, man pages, completion, the version, and mistyped words.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "base/file.h"
#include "pseudo_terminal.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_help {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string text_of(const std::string& file) {
  const auto bytes = fb::read_file(file);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The commands that --help lists.
std::vector<std::string> listed_commands() {
  std::vector<std::string> names;
  bool listed = false;
  for (const std::string& line : lines_of(run_tool({"--help"}).out)) {
    if (line == "Commands:") listed = true;
    if (listed && line.size() > 3 && line.starts_with("  ") && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    if (listed && line.empty()) listed = false;
  }
  return names;
}

// The options that the help of a command has.
std::set<std::string> listed_options(const std::string& command) {
  std::set<std::string> names;
  for (const std::string& line : lines_of(run_tool({command, "--help"}).out)) {
    if (!line.starts_with("  -")) continue;
    const std::string words = line.substr(2, line.find(' ', 2) - 2);
    for (std::size_t at = words.find("--"); at != std::string::npos; at = words.find("--", at + 2))
      names.insert(words.substr(at, words.find(',', at) - at));
  }
  return names;
}

// What the tool prints to a terminal with so many columns.
std::string tool_on_terminal(int columns, const std::vector<std::string>& arguments) {
  return on_terminal(columns, [&] {
    std::vector<std::string> words = {FB_TOOL};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execv(FB_TOOL, pointers.data());
  });
}

}  // namespace

TEST_CASE("help COMMAND is the command's --help") {
  const std::vector<std::string> commands = listed_commands();
  CHECK(commands.size() > 15);
  for (const std::string& command : commands) {
    CAPTURE(command);
    const ToolRun run = run_tool({"help", command});
    CHECK(run.exit_code == 0);
    CHECK(run.out == run_tool({command, "--help"}).out);
    CHECK(contains(run.out, "Usage: facebaker " + command));
  }
  CHECK(run_tool({"help"}).out == run_tool({"--help"}).out);
  const ToolRun wrong = run_tool({"help", "exprot"});
  CHECK(wrong.exit_code == 2);
  CHECK(is_error_line(wrong.err, "help", {"no command \"exprot\"", "did you mean \"export\"?"}));
}

TEST_CASE("the version says what the tool was built with") {
  const std::string text = run_tool({"--version"}).out;
  CHECK(text.starts_with("facebaker "));
  for (const char* line : {"\nformat: 2.1\n", "\ncompiler: ", "\nOpenMP: ", "\ninstruction sets: scalar",
                           "; here: ", "\nlinked: zlib", ", Draco", "\nlinked into the tool: "})
    CHECK_MESSAGE(contains(text, line), line);
}

TEST_CASE("a mistyped command or option gets the nearest one suggested") {
  const auto said = [](const std::vector<std::string>& arguments) {
    const ToolRun run = run_tool(arguments);
    CHECK(run.exit_code == 2);
    return run.err;
  };
  CHECK(said({"sampel"}) == "facebaker: no command \"sampel\"; did you mean \"sample\"? (see --help)\n");
  CHECK(said({"sampel", "sample"}) == said({"sampel"}));
  CHECK(said({"juggle"}) == "facebaker: no command \"juggle\" (see --help)\n");
  CHECK(said({"write-manul"}) == "facebaker: no command \"write-manul\" (see --help)\n");
  CHECK(said({"-x"}) == "facebaker: no option -x (see --help)\n");
  CHECK(said({"--versoin"}) == "facebaker: no option --versoin; did you mean --version? (see --help)\n");
  CHECK(said({"bake", "sample", "--outt", "a.fbk"}) ==
        "facebaker bake: no option --outt; did you mean --out? (see --help)\n");
  CHECK(said({"bake", "sample", "--out", "a.fbk", "--recpie=linear"}) ==
        "facebaker bake: no option --recpie; did you mean --recipe? (see --help)\n");
  CHECK(said({"inspect", "a.fbk", "--frobnicate"}) == "facebaker inspect: no option --frobnicate (see --help)\n");
}

TEST_CASE("an archive is written to a name that ends in .fbk only") {
  const ScratchFolder folder;
  write_tiny_archive(folder / "face.fbk");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"bake", FB_TOY_RIG, "--out", folder / "x.txt"}, {"pack", folder / "face.fbk", "--out", folder / "x.txt"}}) {
    const ToolRun run = run_tool(arguments);
    CHECK(run.exit_code == 2);
    CHECK(is_error_line(run.err, arguments[0], {"--out", folder / "x.txt", "ends in .fbk"}));
  }
  const ToolRun run = run_tool({"export", folder / "face.fbk", folder / "x.txt"});
  CHECK(run.exit_code == 1);
  CHECK(is_error_line(run.err, "export", {folder / "x.txt", ".glb, .onnx, .mdd, .pc2 or .usda"}));
  CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
}

TEST_CASE("help fits the terminal and is coloured for a person only") {
  for (const int columns : {40, 80, 200}) {
    const std::string screen = tool_on_terminal(columns, {"help", "bake"});
    CAPTURE(columns);
    CHECK(contains(screen, "\033[36m--out\033[0m"));
    std::size_t longest = 0;
    for (const std::string& line : lines_of(plain_text(screen))) longest = std::max(longest, line.size());
    CHECK(longest <= std::size_t(std::min(columns, 120)));
    CHECK(longest > std::size_t(std::min(columns, 120)) * 3 / 4);
    CHECK(contains(plain_text(screen), "--out FACE.fbk"));
  }
  CHECK(contains(tool_on_terminal(80, {"sampel"}), "\033[1;31mfacebaker:\033[0m"));
  // A file.
  ToolSetting forced;
  forced.environment = {"FORCE_COLOR=1", "COLUMNS=50"};
  const std::string text = run_tool({"help", "bake"}, forced).out;
  CHECK(!contains(text, "\033"));
  CHECK(contains(text, "\n      The archive to write (.fbk)"));
}

TEST_CASE("man pages and completion have every command and option") {
  const ScratchFolder folder;
  REQUIRE(run_tool({"write-manual", folder / "manual"}).exit_code == 0);
  const std::string overview = text_of(folder / "manual/man1/facebaker.1");
  std::vector<std::string> scripts;
  for (const char* shell : {"bash", "zsh", "fish"}) {
    scripts.push_back(run_tool({"completion", shell}).out);
    CHECK(scripts.back() == text_of(folder / (std::string("manual/completion/") + shell)));
  }
  std::size_t options = 0;
  for (const std::string& command : listed_commands()) {
    CAPTURE(command);
    const auto escaped = [](std::string name) {
      for (std::size_t at = name.find('-'); at != std::string::npos; at = name.find('-', at + 2)) name.insert(at, "\\");
      return name;
    };
    CHECK(contains(overview, "\\fBfacebaker\\-" + escaped(command) + "\\fR(1)"));
    const std::string page = text_of(folder / ("manual/man1/facebaker-" + command + ".1"));
    CHECK(page == run_tool({"help", "--man", command}).out);
    const std::size_t at = scripts[0].find("\n  " + command + ")\n"),
                      zsh_at = scripts[1].find("\n    " + command + ") ");
    REQUIRE(at != std::string::npos);
    REQUIRE(zsh_at != std::string::npos);
    const std::string bash = scripts[0].substr(at, scripts[0].find("\n    ;;\n", at) - at);
    const std::string zsh = scripts[1].substr(zsh_at, scripts[1].find(" ;;\n", zsh_at) - zsh_at);
    for (const std::string& option : listed_options(command)) {
      CAPTURE(option);
      CHECK(contains(page, "\\fB" + escaped(option) + "\\fR"));
      CHECK((contains(bash, option + " ") || contains(bash, option + "'")));
      CHECK(contains(zsh, option + "["));
      CHECK(contains(scripts[2], "__fish_seen_subcommand_from " + command + "' -l " + option.substr(2) + " ") !=
            contains(scripts[2], "__fish_seen_subcommand_from " + command + "' -s h -l " + option.substr(2) + " "));
      ++options;
    }
  }
  CHECK(options > 100);
}

TEST_CASE("man pages are rendered without warnings, and shells take their scripts") {
  const ScratchFolder folder;
  REQUIRE(run_tool({"write-manual", folder / "manual"}).exit_code == 0);
  const auto can_run = [](const char* program) { return std::filesystem::exists(program); };
  if (can_run("/usr/bin/groff")) {
    std::vector<std::string> arguments = {"-ww", "-z", "-man", "-Tutf8"};
    for (const auto& page : std::filesystem::directory_iterator(folder / "manual/man1"))
      arguments.push_back(page.path().string());
    const ToolRun run = run_program("/usr/bin/groff", arguments);
    CHECK(run.exit_code == 0);
    CHECK(run.err == "");
  } else {
    MESSAGE("skipped in part: there is no groff");
  }
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string program = std::string("/usr/bin/") + shell;
    if (!can_run(program.c_str())) continue;
    const ToolRun run = run_program(program, {"-n", folder / (std::string("manual/completion/") + shell)});
    CAPTURE(shell);
    CHECK(run.exit_code == 0);
    CHECK(run.err == "");
  }
  if (can_run("/usr/bin/bash")) {
    const std::string script =
        "source " + (folder / "manual/completion/bash") +
        "; COMP_WORDS=(facebaker bake --recipe lin); COMP_CWORD=3; _facebaker; echo \"${COMPREPLY[@]}\""
        "; COMP_WORDS=(facebaker ba); COMP_CWORD=1; _facebaker; echo \"${COMPREPLY[@]}\""
        "; COMP_WORDS=(facebaker bake --max); COMP_CWORD=2; _facebaker; echo \"${COMPREPLY[@]}\"";
    CHECK(run_program("/usr/bin/bash", {"-c", script}).out == "linear\nbake bag\n--max-bytes --max-error\n");
  }
}

}  // namespace test_tool_help
