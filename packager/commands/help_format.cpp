#include "commands/help_format.h"

#include <CLI/CLI.hpp>

#include "commands/terminal.h"
#include "manual/option_facts.h"

namespace fb::tool {
namespace {

constexpr std::size_t description_column = 29;      // of options and commands, on terminals of
constexpr std::size_t least_width_of_columns = 64;  // so many columns and more; on narrower ones
constexpr std::size_t narrow_indent = 6;            // descriptions begin on a line of their own

}  // namespace

HelpFormat::HelpFormat(std::size_t width, bool coloured) : width_(width), coloured_(coloured) {
  column_width(description_column + 1);
}

std::string HelpFormat::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  return make_description(app) + make_usage(app, name) + make_positionals(app) + make_groups(app, mode) +
         make_subcommands(app, mode) + "\n" + make_footer(app);
}

std::string HelpFormat::make_group(std::string group, bool is_positional,
                                   std::vector<const CLI::Option*> options) const {
  for (const char* heading : {"Options", "Positionals"})  // CLI11 2.6 has them in capitals
    if (CLI::detail::to_lower(group) == CLI::detail::to_lower(heading)) group = heading;
  std::string text = "\n" + in_colour(Colour::heading, group + ":", coloured_) + "\n";
  for (const CLI::Option* option : options) text += make_option(option, is_positional);
  return text;
}

std::string HelpFormat::make_usage(const CLI::App* app, std::string name) const {
  const std::string heading = "Usage:";
  std::string usage = Formatter::make_usage(app, "");  // with the name CLI11 2.6 leaves out the heading
  CLI::detail::trim(usage);
  const std::string lines =
      wrapped(heading + " " + name + usage.substr(heading.size()), 4, width_ > 4 ? width_ - 4 : 0);
  return in_colour(Colour::heading, heading, coloured_) + lines.substr(heading.size()) + "\n";
}

std::string HelpFormat::make_subcommands(const CLI::App* app, CLI::AppFormatMode) const {
  std::string text;
  for (const CLI::App* command : app->get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); }))
    text += make_subcommand(command);
  return text.empty() ? "" : "\n" + in_colour(Colour::heading, "Commands:", coloured_) + "\n" + text;
}

std::string HelpFormat::make_subcommand(const CLI::App* command) const {
  return entry(command->get_name(), "", command->get_description());
}

std::string HelpFormat::make_option(const CLI::Option* option, bool) const {
  const OptionFacts facts = facts_of(*option);
  std::string names;
  for (const std::string& name : facts.names) names += (names.empty() ? "" : ",") + name;
  std::string value;
  if (!facts.positional && !facts.value.empty()) value = " " + facts.value;
  const std::string conditions = conditions_of(facts);
  return entry(names, value + (facts.repeated ? " ..." : ""),
               facts.description + (conditions.empty() ? "" : " [" + conditions + "]"));
}

std::string HelpFormat::make_description(const CLI::App* app) const {
  return wrapped(app->get_description(), 0, width_) + "\n";
}

std::string HelpFormat::make_footer(const CLI::App* app) const {
  const std::string& footer = app->get_footer();
  return footer.empty() ? "" : wrapped(footer + "\n", 0, width_);
}

// The name and what follows it, then the description, in a column of its own where there is room for two.
std::string HelpFormat::entry(const std::string& name, const std::string& rest, const std::string& description) const {
  const bool columns = width_ == 0 || width_ >= least_width_of_columns;
  const std::size_t indent = columns ? description_column + 1 : narrow_indent;
  const std::size_t taken = 2 + name.size() + rest.size();
  std::string text = "  " + in_colour(Colour::name, name, coloured_) + wrapped(rest, narrow_indent, width_);
  if (description.empty()) return text + "\n";
  text += columns && taken < indent ? std::string(indent - taken, ' ') : "\n" + std::string(indent, ' ');
  return text + wrapped(description, indent, width_) + "\n";
}

}  // namespace fb::tool
