#include "manual/completion_script.h"

#include <CLI/CLI.hpp>

#include "base/status.h"
#include "manual/option_facts.h"

namespace fb::tool {
namespace {

// In single quotes, for any of the shells.
std::string single_quoted(const std::string& text) {
  std::string quote = "'";
  for (const char c : text) quote += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quote + "'";
}

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::vector<std::string> command_names(const CLI::App& tool) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(tool)) names.push_back(command->get_name());
  return names;
}

// Whether an option takes the name of a folder, and no other.
bool takes_folder(const OptionFacts& facts) {
  return facts.value == "DIR";
}

// The first sentence or clause of a description, for a list of choices.
std::string short_text(const OptionFacts& facts) {
  std::string text = facts.description.substr(0, facts.description.find_first_of(";:.\n"));
  if (const std::size_t comma = text.find(','); text.size() > 60 && comma != text.npos) text.resize(comma);
  return text;
}

// ---- bash ----

std::string bash_case(const std::vector<std::string>& names, const std::string& action) {
  return "    " + joined(names, "|") + ") " + action + " ;;\n";
}

std::string bash_command(const CLI::App& command, const std::vector<std::string>& topics) {
  std::string values;
  std::vector<std::string> names;
  for (const OptionFacts& facts : options_of(command)) {
    if (facts.positional) continue;
    names.insert(names.end(), facts.names.begin(), facts.names.end());
    if (!facts.choices.empty())
      values += "  " + bash_case(facts.names, "COMPREPLY=($(compgen -W " + single_quoted(joined(facts.choices)) +
                                                  " -- \"$word\")); return");
    else if (takes_folder(facts))
      values += "  " + bash_case(facts.names, "_facebaker_paths -d; return");
    else if (!facts.value.empty())
      values += "  " + bash_case(facts.names, "_facebaker_paths -f; return");
  }
  std::string text = "  " + command.get_name() + ")\n";
  if (!values.empty()) text += "    case \"$before\" in\n" + values + "    esac\n";
  text += "    options=" + single_quoted(joined(names)) + "\n";
  if (!topics.empty()) text += "    topics=" + single_quoted(joined(topics)) + "\n";
  return text + "    ;;\n";
}

std::string bash_script(const CLI::App& tool) {
  std::vector<std::string> names = command_names(tool), general;
  for (const OptionFacts& facts : options_of(tool))
    general.insert(general.end(), facts.names.begin(), facts.names.end());
  std::string text =
      "# Completion of facebaker for bash. Written by `facebaker completion bash`.\n"
      "_facebaker_paths() {\n"
      "  compopt -o filenames 2>/dev/null\n"
      "  mapfile -t COMPREPLY < <(compgen \"$1\" -- \"$word\")\n"
      "}\n"
      "_facebaker() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
      "  local options='' topics=''\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W " +
      single_quoted(joined(names) + " " + joined(general)) +
      " -- \"$word\")\n"
      "    return\n"
      "  fi\n"
      "  case \"$command\" in\n";
  for (const CLI::App* command : commands_of(tool))
    text += bash_command(*command, command->get_name() == "help"         ? names
                                   : command->get_name() == "completion" ? completion_shells()
                                                                         : std::vector<std::string>());
  return text +
         "  esac\n"
         "  if [ \"${word:0:1}\" = - ]; then\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$word\")\n"
         "  elif [ -n \"$topics\" ]; then\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"$topics\" -- \"$word\")\n"
         "  else\n"
         "    _facebaker_paths -f\n"
         "  fi\n"
         "}\n"
         "complete -F _facebaker facebaker\n";
}

// ---- zsh ----

// For the specifications of _arguments: brackets and colons have a meaning there.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string zsh_action(const OptionFacts& facts) {
  if (!facts.choices.empty()) return "(" + joined(facts.choices) + ")";
  return takes_folder(facts) ? "_files -/" : "_files";
}

std::string zsh_specification(const OptionFacts& facts, const std::string& name) {
  std::string text = (facts.repeated ? "*" : "") + name + "[" + zsh_text(short_text(facts)) + "]";
  if (!facts.value.empty()) text += ":" + zsh_text(facts.value) + ":" + zsh_action(facts);
  return single_quoted(text);
}

std::string zsh_command(const CLI::App& command, const std::vector<std::string>& topics) {
  std::string text = "    " + command.get_name() + ") _arguments";
  bool takes_files = false;
  for (const OptionFacts& facts : options_of(command)) {
    takes_files = takes_files || facts.positional;
    if (facts.positional) continue;
    for (const std::string& name : facts.names) text += " \\\n      " + zsh_specification(facts, name);
  }
  if (!topics.empty())
    text += " \\\n      " + single_quoted("1:topic:(" + joined(topics) + ")");
  else if (takes_files)
    text += " \\\n      '*:file:_files'";
  return text + " ;;\n";
}

std::string zsh_script(const CLI::App& tool) {
  std::string text =
      "#compdef facebaker\n"
      "# Completion of facebaker for zsh. Written by `facebaker completion zsh`.\n"
      "_facebaker() {\n"
      "  local -a commands\n"
      "  commands=(\n";
  for (const CLI::App* command : commands_of(tool))
    text += "    " + single_quoted(command->get_name() + ":" + zsh_text(command->get_description())) + "\n";
  text += "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n";
  text += "    _arguments";
  for (const OptionFacts& facts : options_of(tool))
    for (const std::string& name : facts.names) text.append(" ").append(zsh_specification(facts, name));
  text +=
      "\n    return\n  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n"
      "  (( CURRENT-- ))\n"
      "  case $command in\n";
  for (const CLI::App* command : commands_of(tool))
    text += zsh_command(*command, command->get_name() == "help"         ? command_names(tool)
                                  : command->get_name() == "completion" ? completion_shells()
                                                                        : std::vector<std::string>());
  return text + "  esac\n}\n_facebaker \"$@\"\n";
}

// ---- fish ----

std::string fish_option(const std::string& condition, const OptionFacts& facts) {
  std::string text = "complete -c facebaker -n " + single_quoted(condition);
  for (const std::string& name : facts.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!facts.choices.empty())
    text += " -x -a " + single_quoted(joined(facts.choices));
  else if (takes_folder(facts))
    text += " -x -a '(__fish_complete_directories)'";
  else if (!facts.value.empty())
    text += " -r -F";
  return text + " -d " + single_quoted(short_text(facts)) + "\n";
}

std::string fish_topics(const std::string& command, const std::vector<std::string>& topics) {
  return "complete -c facebaker -n '__fish_seen_subcommand_from " + command + "' -f -a " +
         single_quoted(joined(topics)) + "\n";
}

std::string fish_script(const CLI::App& tool) {
  std::string text = "# Completion of facebaker for fish. Written by `facebaker completion fish`.\n";
  for (const OptionFacts& facts : options_of(tool)) text += fish_option("__fish_use_subcommand", facts);
  for (const CLI::App* command : commands_of(tool))
    text += "complete -c facebaker -n __fish_use_subcommand -f -a " + command->get_name() + " -d " +
            single_quoted(command->get_description()) + "\n";
  for (const CLI::App* command : commands_of(tool))
    for (const OptionFacts& facts : options_of(*command))
      if (!facts.positional) text += fish_option("__fish_seen_subcommand_from " + command->get_name(), facts);
  return text + fish_topics("help", command_names(tool)) + fish_topics("completion", completion_shells());
}

}  // namespace

std::vector<std::string> completion_shells() {
  return {"bash", "fish", "zsh"};
}

std::string completion_script(const CLI::App& tool, const std::string& shell) {
  if (shell == "bash") return bash_script(tool);
  if (shell == "zsh") return zsh_script(tool);
  if (shell == "fish") return fish_script(tool);
  fail(Status::invalid_argument, "no completion for the shell \"%s\"; there is bash, fish and zsh", shell.c_str());
}

}  // namespace fb::tool
