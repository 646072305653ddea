#include "manual/option_facts.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace fb::tool {
namespace {

std::vector<std::string> split_words(const std::string& list) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while (begin <= list.size()) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    words.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

std::string join_words(const std::vector<std::string>& words, const char* between = ", ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

// "1 to 9" of "in [1 - 9]".
std::string limits_text(const std::string& range) {
  const std::size_t open = range.find('['), between = range.find(" - "), close = range.find(']');
  if (open == range.npos || between == range.npos || close == range.npos) return range;
  return range.substr(open + 1, between - open - 1) + " to " + range.substr(between + 3, close - between - 3);
}

}  // namespace

// The type of an option is "NAME", "NAME:{one,two}" or "NAME:UINT in [1 - 9]"; "TEXT" and the like where it has no
// name.
OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  facts.positional = option.get_positional();
  facts.required = option.get_required();
  facts.repeated = option.get_expected_max() > 1;
  facts.description = option.get_description();
  for (const CLI::Option* other : option.get_excludes()) facts.excluded.push_back(other->get_name());
  if (facts.positional) {
    facts.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  }
  if (option.get_type_size() == 0) return facts;
  const std::string type = option.get_type_name();
  const std::size_t colon = std::min(type.find(':'), type.size());
  facts.value = type.substr(0, colon);
  const std::size_t open = type.find('{', colon), close = type.rfind('}');
  if (open != type.npos && close != type.npos && open < close)
    facts.choices = split_words(type.substr(open + 1, close - open - 1));
  else if (const std::size_t range = type.find("in [", colon); range != type.npos)
    facts.limits = limits_text(type.substr(range));
  facts.standard = option.get_default_str();
  return facts;
}

std::string conditions_of(const OptionFacts& facts) {
  std::vector<std::string> parts;
  if (facts.required) parts.emplace_back("required");
  if (!facts.choices.empty()) parts.push_back("one of " + join_words(facts.choices));
  if (!facts.limits.empty()) parts.push_back(facts.limits);
  if (!facts.standard.empty()) parts.push_back("default: " + facts.standard);
  if (!facts.excluded.empty()) parts.push_back("not with " + join_words(facts.excluded));
  return join_words(parts, "; ");
}

std::vector<OptionFacts> options_of(const CLI::App& command) {
  std::vector<OptionFacts> all;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_group().empty()) all.push_back(facts_of(*option));
  std::stable_partition(all.begin(), all.end(), [](const OptionFacts& facts) { return facts.positional; });
  return all;
}

std::vector<const CLI::App*> commands_of(const CLI::App& tool) {
  return tool.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); });
}

}  // namespace fb::tool
