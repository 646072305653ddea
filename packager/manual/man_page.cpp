#include "manual/man_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "manual/option_facts.h"

namespace fb::tool {
namespace {

// Text for roff: its escape character and hyphens that are minus signs are escaped, and no line is a request.
std::string roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const bool begins_line = escaped.empty() || escaped.back() == '\n';
    if (begins_line && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\')
      escaped += "\\e";
    else if (c == '-')
      escaped += "\\-";
    else if (c == '\n')
      escaped += "\n.br\n";
    else
      escaped += c;
  }
  return escaped;
}

std::string bold(const std::string& text) {
  return "\\fB" + roff(text) + "\\fR";
}

std::string italic(const std::string& text) {
  return "\\fI" + roff(text) + "\\fR";
}

std::string upper_case(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

std::string title(const std::string& name, const std::string& description) {
  return ".TH " + roff(upper_case(name)) + " 1 \"\" \"FaceBaker " FB_VERSION "\" \"User Commands\"\n.SH NAME\n" +
         roff(name) + " \\- " + roff(description) + "\n";
}

// "SOURCE...", "[OUT]".
std::string argument(const OptionFacts& facts) {
  const std::string name = italic(facts.names.at(0)) + (facts.repeated ? "..." : "");
  return facts.required ? name : "[" + name + "]";
}

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

std::string value_text(const OptionFacts& facts) {
  if (facts.positional || facts.value.empty()) return {};
  return " " + italic(facts.value) + (facts.repeated ? " ..." : "");
}

std::string entry(const OptionFacts& facts) {
  std::string names;
  for (const std::string& name : facts.names)
    names += (names.empty() ? "" : ", ") + (facts.positional ? italic(name) : bold(name));
  std::string text = ".TP\n" + names + value_text(facts) + "\n" + roff(sentence(facts.description)) + "\n";
  if (const std::string conditions = conditions_of(facts); !conditions.empty())
    text += roff("(" + conditions + ")") + "\n";
  return text;
}

std::string entries(const std::string& heading, const std::vector<OptionFacts>& options, bool positional) {
  std::string text;
  for (const OptionFacts& facts : options)
    if (facts.positional == positional) text += entry(facts);
  return text.empty() ? text : ".SH " + heading + "\n" + text;
}

std::string page_name(const CLI::App& command) {
  return "facebaker-" + command.get_name();
}

}  // namespace

std::string man_page(const CLI::App& tool) {
  std::string text = title("facebaker", tool.get_description());
  text += ".SH SYNOPSIS\n.B facebaker\n" + italic("COMMAND") + " [" + italic("OPTIONS") + "] ...\n.SH COMMANDS\n";
  for (const CLI::App* command : commands_of(tool))
    text += ".TP\n" + bold(page_name(*command)) + "(1)\n" + roff(sentence(command->get_description())) + "\n";
  text += entries("OPTIONS", options_of(tool), false);
  text += ".SH NOTES\n" + roff(tool.get_footer()) + "\n";
  text +=
      ".SH ENVIRONMENT\n"
      ".TP\n.B NO_COLOR\nSet: nothing is coloured.\n"
      ".TP\n.B FORCE_COLOR\nSet, but not to 0: text is coloured that goes to no terminal, except to files.\n"
      ".TP\n.B COLUMNS\nHow wide help is where the terminal does not tell.\n"
      ".TP\n.B FB_INSTRUCTION_SET\nThe fastest instruction set to pose with, for tests; results are the same.\n"
      ".TP\n.B OMP_NUM_THREADS\nThreads that are used where \\fB\\-\\-threads\\fR does not say.\n"
      ".SH SEE ALSO\n";
  std::string pages;
  for (const CLI::App* command : commands_of(tool))
    pages += (pages.empty() ? ".BR " : " ,\n.BR ") + roff(page_name(*command)) + " (1)";
  return text + pages + "\n";
}

std::string man_page(const CLI::App& tool, const CLI::App& command) {
  const std::vector<OptionFacts> options = options_of(command);
  std::string text = title(page_name(command), command.get_description());
  text += ".SH SYNOPSIS\n.B facebaker " + roff(command.get_name()) + "\n[" + italic("OPTIONS") + "]";
  for (const OptionFacts& facts : options)
    if (facts.positional) text += " " + argument(facts);
  text += "\n.SH DESCRIPTION\n" + roff(sentence(command.get_description())) + "\n";
  if (!command.get_footer().empty()) text += ".PP\n" + roff(command.get_footer()) + "\n";
  text += entries("ARGUMENTS", options, true) + entries("OPTIONS", options, false);
  const std::string exit_codes = tool.get_footer();
  if (const std::size_t at = exit_codes.find("Exit code:"); at != exit_codes.npos)
    text += ".SH EXIT STATUS\n" + roff(exit_codes.substr(at)) + "\n";
  return text + ".SH SEE ALSO\n.BR facebaker (1)\n";
}

}  // namespace fb::tool
