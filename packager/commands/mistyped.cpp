#include "commands/mistyped.h"

#include <CLI/CLI.hpp>

#include "base/match_names.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "manual/option_facts.h"

namespace fb::tool {

std::string unknown_command(const CLI::App& tool, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(tool)) names.push_back(command->get_name());
  const auto meant = nearest_name(word, names);
  return format("no command \"%s\"", shown(word).c_str()) +
         (meant ? format("; did you mean \"%s\"?", meant->c_str()) : std::string());
}

std::string unknown_option(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& left : command.remaining()) {
    const std::string word = left.substr(0, left.find('='));
    if (!word.starts_with('-') || word == "-" || word == "--") continue;
    const auto meant = word.starts_with("--") ? nearest_name(word, names) : std::nullopt;
    return format("no option %s", shown(word).c_str()) +
           (meant ? format("; did you mean %s?", meant->c_str()) : std::string());
  }
  return {};
}

}  // namespace fb::tool
