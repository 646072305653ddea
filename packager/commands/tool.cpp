#include "commands/tool.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <facebaker/facebaker.hpp>
#include <filesystem>
#include <new>
#include <sstream>
#include <system_error>

#include "base/status.h"
#include "commands/commands.h"
#include "commands/exit_guard.h"
#include "commands/help_format.h"
#include "commands/interrupt.h"
#include "commands/mistyped.h"
#include "commands/own_text.h"
#include "commands/results.h"
#include "commands/terminal.h"
#include "commands/tool_version.h"

namespace fb::tool {
namespace {

constexpr std::size_t widest_help = 120;  // columns; longer lines are hard to read

int report_failure(const CLI::App& tool, const std::string& message, int exit_code) {
  const auto commands = tool.get_subcommands();
  const std::string who = "facebaker" + (commands.empty() ? "" : " " + commands[0]->get_name()) + ":";
  print_line(message, in_colour(Colour::error, who, takes_colour(STDERR_FILENO)) + " ");
  return exit_code;
}

// Whether the first word of the command line is neither a command nor an option. A later one may be a command, such as
// the source "sample", and would be taken for it.
bool is_mistyped(const CLI::App& tool, const char* first) {
  const auto commands = tool.get_subcommands([](const CLI::App*) { return true; });
  return *first != '-' &&
         std::ranges::none_of(commands, [&](const CLI::App* command) { return command->get_name() == first; });
}

// What is wrong with the command line. `first`: its first word; null: it has none.
std::string wrong_use_text(const CLI::App& tool, const CLI::ParseError& wrong, const char* first) {
  if (!first) return "give a command (see --help)";
  const auto commands = tool.get_subcommands();
  const std::string option = unknown_option(commands.empty() ? tool : *commands[0]);
  return (option.empty() ? wrong.what() : option) + " (see --help)";
}

// The message after Ctrl-C: whether the same command continues the work.
std::string interrupted_text(const CLI::App& tool) {
  const CLI::App* command = tool.get_subcommands().at(0);
  const bool compares = command->get_name() == "compare";
  if (compares && command->count("--work") == 0) return "interrupted; with --work DIR the same command could go on";
  return compares || command->get_name() == "sample" || command->get_name() == "bake" || command->get_name() == "farm"
             ? "interrupted; what is done is kept, run the same command to go on"
             : "interrupted";
}

// Prints what --help or --version asks for.
int print_help(const CLI::App& tool, const CLI::Success& help) {
  std::ostringstream text;
  text.exceptions(std::ios::badbit | std::ios::failbit);
  const int exit_code = tool.exit(help, text, text);
  print_own_text(text.str());
  finish_results();
  return exit_code;
}

// Runs what the command line says.
int obey(CLI::App& tool, int argc, char** argv) {
  if (argc > 1 && is_mistyped(tool, argv[1]))
    return report_failure(tool, unknown_command(tool, argv[1]) + " (see --help)", 2);
  try {
    tool.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return print_help(tool, help);
  }
  finish_results();
  return 0;
}

int run_commands(int argc, char** argv) {
  CLI::App tool("Bakes facial rigs into small .fbk archives and poses them anywhere.", "facebaker");
  const int shown = results_descriptor();
  const std::size_t width = std::min(terminal_width(shown), widest_help);
  const auto help_format = std::make_shared<HelpFormat>(width, takes_colour(shown));
  help_format->label("SUBCOMMAND", "COMMAND");
  tool.formatter(help_format);
  tool.set_version_flag("--version", tool_version, "Print the version and what the tool was built with, and exit");
  tool.set_help_flag("-h,--help", "Print this text and exit");
  tool.require_subcommand(1);
  const Command commands(tool);
  add_sample(commands);
  add_plan(commands);
  add_check(commands);
  add_bake(commands);
  add_eval(commands);
  add_diff(commands);
  add_compare(commands);
  add_inspect(commands);
  add_verify(commands);
  add_sign(commands);
  add_pack(commands);
  add_bag(commands);
  add_pose(commands);
  add_solve(commands);
  add_view(commands);
  add_export(commands);
  add_header(commands);
  add_bench(commands);
  add_rig_host(commands);
  add_farm(commands);
  add_help(commands);
  add_completion(commands);
  add_write_manual(commands);
  // After the commands, which would inherit it.
  tool.footer(
      "SOURCE is a dataset folder, a rig plugin (librig_NAME.so), a .glb or .gltf with morph targets,\n"
      "exec:COMMAND, a program that speaks the rig protocol, or \"sample\", the built-in face.\n"
      "Exit code: 0 success, 1 failure, 2 wrong use.");

  watch_interrupts();
  const ExitGuard guard(argc > 1 ? fb::format("facebaker %s", argv[1]) : "facebaker");
  const char* const first = argc > 1 ? argv[1] : nullptr;
  try {
    return obey(tool, argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return report_failure(tool, wrong_use_text(tool, wrong, first), 2);
  } catch (const fb::Error& error) {
    return report_failure(tool, error.status() == fb::Status::interrupted ? interrupted_text(tool) : error.what(), 1);
  } catch (const facebaker::Error& error) {
    return report_failure(tool, error.status() == FB_ERROR_INTERRUPTED ? interrupted_text(tool) : error.what(), 1);
  } catch (const std::bad_alloc&) {
    return report_failure(tool, "out of memory", 1);
  } catch (const std::exception& error) {
    return report_failure(tool, error.what(), 1);
  } catch (...) {
    return report_failure(tool, "an unknown exception", 1);
  }
}

}  // namespace

void use_passive_waiting(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") || ::setenv("OMP_WAIT_POLICY", "PASSIVE", 0) != 0) return;
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  ::execv(program.c_str(), argv);  // if this fails, the program works, only slower
}

int run_tool(int argc, char** argv) {
  try {
    reserve_standard_output();
    return run_commands(argc, argv);
  } catch (...) {  // before there are commands, or while a failure is told
    std::fputs("facebaker: out of memory\n", stderr);
    return 1;
  }
}

}  // namespace fb::tool
