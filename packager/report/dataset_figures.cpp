#include "report/dataset_figures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "report/table.h"

namespace fb::tool {
namespace {

using CheckJson = nlohmann::json;

double number_or_nan(const CheckJson& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : NAN;
}

std::vector<DatasetFinding> findings_of(const CheckJson& list) {
  std::vector<DatasetFinding> findings;
  for (const CheckJson& one : list) findings.push_back({one.at("kind"), one.at("clip"), one.at("text")});
  return findings;
}

void read_coverage(const CheckJson& json, DatasetFigures& figures) {
  if (const CheckJson& active = json.at("active"); !active.is_null()) {
    active.at("training").get_to(figures.active_training);
    if (active.contains("measured")) active.at("measured").get_to(figures.active_measured);
  }
  if (const CheckJson& pairs = json.at("pairs"); !pairs.is_null()) {
    pairs.at("all").get_to(figures.pairs);
    pairs.at("seen").get_to(figures.pairs_seen);
    for (const CheckJson& pair : pairs.at("missing"))
      figures.missing_pairs.push_back(pair.at(0).get<std::string>() + " and " + pair.at(1).get<std::string>());
  }
  if (json.at("coverage").is_string()) json.at("coverage").get_to(figures.coverage);
}

bool reaches_ends(const ControlRange& control) {
  const double slack = 0.05 * (control.maximum - control.minimum);
  return control.lowest <= control.minimum + slack && control.highest >= control.maximum - slack;
}

// The controls that training poses do not take near both ends of their ranges.
std::string ranges_text(const DatasetFigures& figures) {
  constexpr std::size_t most_listed = 12;
  Table table({"control", "min", "max", "default", "lowest", "highest"});
  std::size_t short_of_ends = 0;
  for (const ControlRange& control : figures.controls) {
    if (!std::isfinite(control.lowest) || reaches_ends(control) || ++short_of_ends > most_listed) continue;
    std::vector<std::string> row = {control.name};
    for (const double value : {control.minimum, control.maximum, control.rest, control.lowest, control.highest})
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
  for (const DatasetClip& clip : figures.clips)
    table.add({clip.name, clip.kind, clip.split, std::to_string(clip.frames), std::to_string(clip.evaluated)});
  return table.text();
}

}  // namespace

DatasetFigures read_dataset_figures(const facebaker::Report& report) {
  const CheckJson json = CheckJson::parse(report.json());
  DatasetFigures figures;
  json.at("dataset").get_to(figures.folder);
  json.at("name").get_to(figures.name);
  json.at("units").get_to(figures.units);
  json.at("diagonal").get_to(figures.diagonal);
  json.at("bakeable").get_to(figures.bakeable);
  figures.faults = findings_of(json.at("faults"));
  figures.warnings = findings_of(json.at("warnings"));
  for (const CheckJson& clip : json.at("clips"))
    figures.clips.push_back(
        {clip.at("name"), clip.at("kind"), clip.at("split"), clip.at("frames"), clip.at("evaluated")});
  for (const CheckJson& control : json.at("controls"))
    figures.controls.push_back({control.at("name"), control.at("group"), number_or_nan(control, "min"),
                                number_or_nan(control, "max"), number_or_nan(control, "default"),
                                number_or_nan(control, "lowest"), number_or_nan(control, "highest"),
                                number_or_nan(control, "strong"), number_or_nan(control, "beyond")});
  read_coverage(json, figures);
  const CheckJson details = CheckJson::parse(report.details());
  details.at("vertex_motion").get_to(figures.vertex_motion);
  details.at("pair_shares").get_to(figures.pair_shares);
  for (const CheckJson& frame : details.at("largest_frames"))
    figures.largest_frames.push_back({frame.at("clip"), frame.at("frame")});
  return figures;
}

std::string dataset_text(const DatasetFigures& figures) {
  std::string text;
  for (const DatasetFinding& fault : figures.faults) text += "fault: " + fault.text + "\n";
  for (const DatasetFinding& warning : figures.warnings) text += "warning: " + warning.text + "\n";
  if (!text.empty()) text += "\n";
  if (!figures.clips.empty()) text += clips_text(figures) + "\n";
  if (!figures.active_training.empty()) {
    text += ranges_text(figures);
    text += format("%llu of %llu pairs of controls are strongly active at once in some pose to train on.\n",
                   static_cast<unsigned long long>(figures.pairs_seen), static_cast<unsigned long long>(figures.pairs));
  }
  return text + (figures.bakeable ? "The folder can be baked.\n" : "The folder cannot be baked.\n");
}

}  // namespace fb::tool
