#include "bake/measure/certificate.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "bake/rig/json_field.h"
#include "base/decimal_points.h"
#include "base/hash.h"
#include "base/status.h"
#include "figures/json_fields.h"

namespace fb::bake {
namespace {

using Json = nlohmann::ordered_json;

// To six significant digits.
double rounded(double value) {
  const DecimalPoints decimal_points;
  return std::strtod(format("%.6g", value).c_str(), nullptr);
}

void add(Json& json, const Errors& errors) {
  FieldWriter<Json> writer(json, {.rounded = rounded});
  visit_distances(writer, errors);
  for (const ChannelErrors& channel : errors.channels)
    json["channels"].push_back({{"name", channel.name}, {"rms", rounded(channel.rms)}, {"max", rounded(channel.max)}});
}

// A certificate that comes from anyone.
Json parsed(const std::string& certificate) {
  Json json = object_in(certificate);
  return json.is_null() ? Json::object() : json;
}

std::optional<double> figure(const Json& part, const char* key) {
  if (!part.is_object() || !part.contains(key) || !part[key].is_number()) return std::nullopt;
  return part[key].get<double>();
}

// Keys of the errors that may stand for the face, the best first: on unseen poses, on poses held back, on those trained
// on.
constexpr std::array<const char*, 3> measured_parts = {"independent", "held_back", "dependency"};

// The first of them that there is, else null.
const char* measured_part(const Json& certificate) {
  for (const char* part : measured_parts)
    if (figure(certificate.value(part, Json()), "max")) return part;
  return nullptr;
}

Json kind_list(const std::vector<KindErrors>& kinds) {
  Json list = Json::array();
  for (const KindErrors& kind : kinds) {
    Json& figures = list.emplace_back(Json{{"kind", kind.kind}});
    add(figures, kind.errors);
  }
  return list;
}

Json independent_errors(const EvalReport& report) {
  Json json = {{"split", report.clips.at(0).split}};
  add(json, report.total);
  for (const ClipErrors& clip : report.clips) {
    Json figures = {{"name", clip.name}, {"kind", clip.kind}};
    add(figures, clip.errors);
    json["clips"].push_back(std::move(figures));
  }
  json["kinds"] = kind_list(report.kinds);
  if (report.expectation) json["expected"] = fields_of<Json>(*report.expectation, {.rounded = rounded});
  if (!report.quality) return json;
  for (const RegionErrors& region : report.quality->regions)
    json["regions"].push_back({{"name", region.name},
                               {"vertices", region.vertices},
                               {"mse", rounded(region.mse)},
                               {"max", rounded(region.max)},
                               {"mfm", rounded(region.mfm)},
                               {"p99fm", rounded(region.p99fm)}});
  json["normals"] = {{"rms_degrees", rounded(report.quality->normal_rms)},
                     {"p99_degrees", rounded(report.quality->normal_p99)}};
  const ContactErrors& contact = report.quality->contact;
  json["contact"] = {{"looked_at", contact.looked_at},
                     {"frames", contact.frames},
                     {"pairs", contact.pairs},
                     {"rms", rounded(contact.rms)},
                     {"max", rounded(contact.max)},
                     {"open", contact.open},
                     {"deep", contact.deep},
                     {"vertex_share", rounded(contact.vertex_share)},
                     {"error_share", rounded(contact.error_share)}};
  return json;
}

}  // namespace

const char* learned_text(bool learned) {
  return learned ? "yes" : "no";
}

std::string certificate(const CertifiedFace& face) {
  Json json = {{"learned", learned_text(face.learned)}};
  add(json["dependency"], face.dependency);
  if (face.held_back.total.frames > 0) {
    add(json["held_back"], face.held_back.total);
    json["held_back"]["kinds"] = kind_list(face.held_back.kinds);
  }
  json["independent"] = face.independent ? independent_errors(*face.independent) : Json();
  add(json["quantisation"], face.quantisation);
  if (const auto& exact = face.exact)
    json["exact"] = {{"poses", exact->frames}, {"rms", rounded(exact->rms)}, {"max", rounded(exact->max)}};
  for (const LevelErrors& level : face.levels) {
    Json figures = {{"vertices", level.vertices}, {"polygons", level.polygons}, {"coefficients", level.coefficients}};
    add(figures, level.own);
    figures["surface"] = {{"rms", rounded(level.surface.rms)}, {"max", rounded(level.surface.max)}};
    json["levels"].push_back(std::move(figures));
  }
  if (!face.warnings.empty()) json["warnings"] = face.warnings;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void add_requantisation_errors(std::string& certificate, const Errors& moved) {
  Json json = parsed(certificate);
  const Json before = json.value("repacked", Json());
  // Triangle inequality: the displacement by two repackings is at most the sum of both, of rms as of max.
  const double rms = rounded(figure(before, "rms").value_or(0) + moved.rms),
               max = rounded(figure(before, "max").value_or(0) + moved.max);
  json["repacked"] = {{"frames", moved.frames}, {"mse", rounded(rms * rms)}, {"rms", rms}, {"max", max}};
  const char* const measured = measured_part(json);
  if (measured && figure(json[measured], "rms") && figure(json[measured], "max")) {
    const double bound = *figure(json[measured], "rms") + rms;
    json["bound"] = {{"of", measured},
                     {"mse", rounded(bound * bound)},
                     {"rms", rounded(bound)},
                     {"max", rounded(*figure(json[measured], "max") + max)}};
  }
  certificate = json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void add_exact_errors(std::string& certificate, const Errors& moved) {
  Json json = parsed(certificate);
  const Json before = json.value("exact", Json());
  if (!figure(before, "rms") || !figure(before, "max")) return;  // nothing was measured
  json["exact"] = {{"poses", moved.frames},
                   {"rms", rounded(*figure(before, "rms") + moved.rms)},
                   {"max", rounded(*figure(before, "max") + moved.max)}};
  certificate = json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<CertifiedErrors> certified_errors(const std::string& certificate) {
  const Json json = parsed(certificate);
  if (!measured_part(json)) return std::nullopt;
  CertifiedErrors errors;
  for (const char* part : measured_parts)
    errors.largest = std::max(errors.largest, figure(json.value(part, Json()), "max").value_or(0));
  errors.repacked = figure(json.value("repacked", Json()), "max").value_or(0);
  return errors;
}

std::string certificate_summary(const std::string& certificate) {
  const Json json = parsed(certificate);
  std::string text;
  const auto add = [&](const char* what, const char* part) {
    const Json figures = json.value(part, Json());
    if (const auto max = figure(figures, "max"))
      text += format("%s: rms %.3g, max %.3g of the diagonal\n", what, figure(figures, "rms").value_or(0), *max);
  };
  if (json.value("learned", Json()) == learned_text(false)) text += "learned: no\n";
  const char* const measured = measured_part(json);
  const std::map<std::string_view, const char*> names = {{"independent", "certified error on unseen poses"},
                                                         {"held_back", "certified error on poses held back"},
                                                         {"dependency", "certified error on training poses"}};
  if (measured) add(names.at(measured), measured);
  add("displaced by repacking", "repacked");
  add("bound of the error since", "bound");
  for (const Json& warning : json.value("warnings", Json::array()))
    if (warning.is_string()) text += "warning: " + warning.get<std::string>() + "\n";
  return text;
}

std::uint64_t training_hash(const PoseSet& poses) {
  constexpr std::size_t at_once = 64;
  const std::size_t width = poses.source().rest().points.size();
  std::vector<float> points(at_once * width);
  std::uint64_t hash = 0;
  for (std::size_t first = 0; first < poses.size(); first += at_once) {
    const std::size_t count = std::min(at_once, poses.size() - first);
    poses.read_points(first, count, std::span(points).first(count * width));
    for (std::size_t i = 0; i < count; ++i) hash = hash64_little(std::span(points).subspan(i * width, width), hash);
  }
  return hash64_little(poses.controls(), hash);
}

}  // namespace fb::bake
