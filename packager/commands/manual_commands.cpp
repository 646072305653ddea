// What the tool says of itself: help, man pages, completion for shells.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "base/file.h"
#include "commands/commands.h"
#include "commands/mistyped.h"
#include "commands/own_text.h"
#include "manual/completion_script.h"
#include "manual/man_page.h"
#include "manual/option_facts.h"

namespace fb::tool {
namespace {

// Null for no topic.
const CLI::App* find_topic(const CLI::App& tool, const std::string& topic) {
  if (topic.empty()) return nullptr;
  for (const CLI::App* command : commands_of(tool))
    if (command->get_name() == topic) return command;
  throw CLI::ValidationError(unknown_command(tool, topic));
}

void write_manual(const CLI::App& tool, const std::filesystem::path& folder) {
  const std::filesystem::path pages = folder / "man1", scripts = folder / "completion";
  std::filesystem::create_directories(pages);
  std::filesystem::create_directories(scripts);
  write_file(pages / "facebaker.1", man_page(tool));
  for (const CLI::App* command : commands_of(tool))
    write_file(pages / ("facebaker-" + command->get_name() + ".1"), man_page(tool, *command));
  for (const std::string& shell : completion_shells()) write_file(scripts / shell, completion_script(tool, shell));
}

}  // namespace

void add_help(Command tool) {
  auto topic = std::make_shared<std::string>();
  auto as_man_page = std::make_shared<bool>(false);
  const Command app = tool.add_command("help", "Say what a command does and which options it has");
  app.add_option("COMMAND", *topic, "The command; without one, all of them are listed");
  app.add_flag("--man", *as_man_page, "Print the man page, in roff, instead: facebaker help --man bake | man -l -");
  app.when_called([&tool = tool.app(), topic, as_man_page] {
    const CLI::App* command = find_topic(tool, *topic);
    if (*as_man_page)
      print_own_text(command ? man_page(tool, *command) : man_page(tool));
    else
      print_own_text(command ? command->help("facebaker")
                             : tool.get_formatter()->make_help(&tool, "facebaker", CLI::AppFormatMode::Normal));
  });
}

void add_completion(Command tool) {
  auto shell = std::make_shared<std::string>();
  const Command app = tool.add_command("completion", "Print a script by which a shell completes commands and options");
  app.add_option("SHELL", *shell, "bash, fish or zsh").one_of(completion_shells()).required();
  app.footer("For bash, for this session: source <(facebaker completion bash). Packages install the scripts.");
  app.when_called([&tool = tool.app(), shell] { print_own_text(completion_script(tool, *shell)); });
}

// Not shown: what the build writes to be installed.
void add_write_manual(Command tool) {
  auto folder = std::make_shared<std::string>();
  const Command app = tool.add_command("write-manual", "Write all man pages and completion scripts into a folder");
  app.app().group("");
  app.add_option("FOLDER", *folder, "The folder; it is created").required();
  app.when_called([&tool = tool.app(), folder] { write_manual(tool, *folder); });
}

}  // namespace fb::tool
