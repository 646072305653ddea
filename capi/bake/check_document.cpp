#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/documents.h"

namespace fb::capi {
namespace {

using Json = nlohmann::ordered_json;
using namespace fb::bake;

Json findings_of(const DatasetCheck& check, bool faults) {
  Json list = Json::array();
  for (const Finding& finding : check.findings)
    if (finding.fault == faults)
      list.push_back({{"kind", finding.kind}, {"clip", finding.clip}, {"text", finding.text}});
  return list;
}

Json clips_of(const DatasetCheck& check) {
  Json list = Json::array();
  for (const CheckedClip& clip : check.clips)
    list.push_back({{"name", clip.name},
                    {"kind", name_of(clip.kind)},
                    {"split", name_of(clip.split)},
                    {"frames", clip.frames},
                    {"evaluated", clip.evaluated}});
  return list;
}

// The value of a control at a fraction of the way from rest to an end of its range.
double value_at(const Control& control, double down, double up, bool high) {
  return high ? control.rest + up * (double(control.maximum) - control.rest)
              : control.rest - down * (double(control.rest) - control.minimum);
}

Json controls_of(const DatasetCheck& check) {
  Json list = Json::array();
  for (std::size_t c = 0; c < check.schema.control_count(); ++c) {
    const Control& control = check.schema.controls[c];
    Json json = {{"name", control.name},
                 {"group", control.group},
                 {"min", control.minimum},
                 {"max", control.maximum},
                 {"default", control.rest}};
    if (check.coverage) {
      const ControlCoverage& covered = check.coverage->controls[c];
      json["lowest"] = value_at(control, covered.lowest[0], covered.highest[0], false);
      json["highest"] = value_at(control, covered.lowest[0], covered.highest[0], true);
      json["strong"] = covered.strong[0];
      json["beyond"] = covered.beyond;
    }
    list.push_back(std::move(json));
  }
  return list;
}

// Pairs of controls seen strongly active at once, of all there are; and those that poses to measure on have and poses
// to train on lack most.
Json pairs_of(const DatasetCheck& check) {
  const std::size_t width = check.schema.control_count();
  std::size_t seen = 0;
  for (std::size_t a = 0; a < width; ++a)
    for (std::size_t b = a + 1; b < width; ++b) seen += check.pair_shares[a * width + b] > 0;
  Json missing = Json::array();
  for (const PairCoverage& pair : check.coverage->pairs)
    if (check.measured_on && pair.share[0] == 0)
      missing.push_back({check.schema.controls[pair.controls[0]].name, check.schema.controls[pair.controls[1]].name});
  return {{"all", width * (width - 1) / 2}, {"seen", seen}, {"missing", missing}};
}

}  // namespace

std::string check_json(const std::string& dataset, const DatasetCheck& check) {
  std::size_t poses = 0, evaluated = 0;
  for (const CheckedClip& clip : check.clips) {
    poses += clip.frames;
    evaluated += clip.evaluated;
  }
  Json json = {{"dataset", dataset},
               {"name", check.schema.name},
               {"units", check.schema.units},
               {"diagonal", check.diagonal},
               {"vertices", check.vertices},
               {"bakeable", check.bakeable},
               {"faults", findings_of(check, true)},
               {"warnings", findings_of(check, false)},
               {"poses", poses},
               {"evaluated", evaluated},
               {"clips", clips_of(check)},
               {"controls", controls_of(check)},
               {"active", nullptr},
               {"pairs", nullptr},
               {"coverage", nullptr}};
  if (check.coverage) {
    json["active"] = {{"training", check.coverage->strong_counts[0]}};
    if (check.measured_on) json["active"]["measured"] = check.coverage->strong_counts[1];
    json["pairs"] = pairs_of(check);
    if (check.measured_on) json["coverage"] = coverage_text(*check.coverage, check.schema);
  }
  return json_text(json);
}

std::string check_details_json(const DatasetCheck& check) {
  Json frames = Json::array();
  for (const LargeFrame& frame : check.largest)
    frames.push_back({{"clip", frame.clip}, {"frame", frame.frame}, {"motion", frame.motion}});
  return json_text(
      {{"vertex_motion", check.vertex_motion}, {"pair_shares", check.pair_shares}, {"largest_frames", frames}});
}

}  // namespace fb::capi
