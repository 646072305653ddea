// The form of help texts: as wide as the terminal, with colour where a person looks. What stands where is decided here,
// because releases of CLI11 (2.1 and 2.6 were compared) place headings, empty lines and line ends otherwise.
#pragma once

#include <CLI/Formatter.hpp>

namespace fb::tool {

class HelpFormat final : public CLI::Formatter {
 public:
  // width: columns of a line; 0: lines are not broken.
  HelpFormat(std::size_t width, bool coloured);

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_group(std::string group, bool is_positional, std::vector<const CLI::Option*> options) const override;
  std::string make_usage(const CLI::App* app, std::string name) const override;
  std::string make_subcommands(const CLI::App* app, CLI::AppFormatMode mode) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_footer(const CLI::App* app) const override;

 private:
  std::string entry(const std::string& name, const std::string& rest, const std::string& description) const;

  std::size_t width_;
  bool coloured_;
};

}  // namespace fb::tool
