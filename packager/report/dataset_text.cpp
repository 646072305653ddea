#include "report/dataset_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "figures/json_fields.h"
#include "report/table.h"

namespace fb::tool {
namespace {

bool reaches_ends(const UsedRange& control) {
  const double slack = 0.05 * (double(control.maximum) - control.minimum);
  return control.lowest <= control.minimum + slack && control.highest >= control.maximum - slack;
}

// The controls that training poses do not take near both ends of their ranges.
std::string ranges_text(const DatasetFigures& figures) {
  constexpr std::size_t most_listed = 12;
  Table table({"control", "min", "max", "default", "lowest", "highest"});
  std::size_t short_of_ends = 0;
  for (const UsedRange& control : figures.controls) {
    if (!std::isfinite(control.lowest) || reaches_ends(control) || ++short_of_ends > most_listed) continue;
    std::vector<std::string> row = {control.name};
    for (const double value :
         {double(control.minimum), double(control.maximum), double(control.rest), control.lowest, control.highest})
      row.push_back(format("%.3g", value));
    table.add(std::move(row));
  }
  if (short_of_ends == 0) return "Every control comes within 5 % of both ends of its range in poses to train on.\n";
  return format("%zu of %zu controls do not come within 5 %% of both ends of their ranges in poses to train on:\n\n",
                short_of_ends, figures.controls.size()) +
         table.text() +
         (short_of_ends > most_listed ? format("and %zu more\n", short_of_ends - most_listed) : std::string()) + "\n";
}

std::string clips_text(const DatasetFigures& figures) {
  Table table({"clip", "kind", "split", "frames", "with points"});
  for (const CheckedClip& clip : figures.clips)
    table.add({clip.name, clip.kind, clip.split, std::to_string(clip.frames), std::to_string(clip.evaluated)});
  return table.text();
}

}  // namespace

DatasetFigures read_dataset_figures(const facebaker::Report& report) {
  const nlohmann::json json = nlohmann::json::parse(report.details());
  DatasetFigures figures;
  FieldReader reader(json);
  visit_fields(reader, figures);
  return figures;
}

std::string dataset_text(const DatasetFigures& figures) {
  std::string text;
  for (const Finding& fault : figures.faults) text += "fault: " + fault.text + "\n";
  for (const Finding& warning : figures.warnings) text += "warning: " + warning.text + "\n";
  if (!text.empty()) text += "\n";
  if (!figures.clips.empty()) text += clips_text(figures) + "\n";
  if (figures.pairs) {
    text += ranges_text(figures);
    text += format("%zu of %zu pairs of controls are strongly active at once in some pose to train on.\n",
                   figures.pairs->seen, figures.pairs->all);
  }
  return text + (figures.bakeable ? "The folder can be baked.\n" : "The folder cannot be baked.\n");
}

}  // namespace fb::tool
