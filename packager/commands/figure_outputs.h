#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace fb::tool {

// Where the figures of a measuring command go: --json FILE, --report DIR, standard output.
struct FigureOutputs {
  std::string json, report;

  // Declares both options; `also` ends the description of --report.
  void add_to(CLI::App& command, const char* also = "");
  // Fails if something could not be written: better before the work than after it.
  void check() const;
  // Writes what was asked for, the report as NAME.json and NAME.md; prints the table, or the JSON with --json -.
  void write(const std::string& name, const std::string& figures, const std::string& table) const;
};

// Writes name.json and name.md into a folder that claim_report_folder made.
void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& figures,
                  const std::string& table);

}  // namespace fb::tool
