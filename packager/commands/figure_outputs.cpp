#include "commands/figure_outputs.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "base/file.h"
#include "commands/command_options.h"
#include "report/face_report.h"

namespace fb::tool {

void FigureOutputs::add_to(CLI::App& command, const char* also) {
  command.add_option("--json", json, "Write the figures as JSON; - for standard output, in place of the table")
      ->type_name("FILE");
  add_report(command, report, also);
}

void FigureOutputs::check() const {
  if (!json.empty() && json != "-") const AtomicFile trial(json);
  if (!report.empty()) claim_report_folder(report);
}

void FigureOutputs::write(const std::string& name, const std::string& figures, const std::string& table) const {
  if (!json.empty() && json != "-") write_file(json, figures);
  if (!report.empty()) write_report(report, name, figures, table);
  std::fputs(json == "-" ? figures.c_str() : table.c_str(), stdout);
}

void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& figures,
                  const std::string& table) {
  write_file(folder / (name + ".json"), figures);
  write_file(folder / (name + ".md"), table);
}

}  // namespace fb::tool
