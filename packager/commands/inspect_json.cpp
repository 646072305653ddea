#include "commands/inspect_json.h"

#include <nlohmann/json.hpp>

#include "base/status.h"
#include "commands/json_text.h"
#include "commands/table.h"

namespace fb::tool {
namespace {

using Json = nlohmann::ordered_json;
using bake::VerifyReport;

Json network_graph(const PackedModel& model) {
  Json regions = Json::array();
  for (const PackedRegion& region : model.regions) {
    Json layers = Json::array();
    for (const PackedLayer& layer : region.layers)
      layers.push_back({{"inputs", layer.inputs},
                        {"outputs", layer.outputs},
                        {"activation", name_of(layer.activation)},
                        {"skip", layer.skip},
                        {"bits", layer.wide ? 16 : 8}});
    regions.push_back({{"name", region.name},
                       {"inputs", region.features.size()},
                       {"gate", region.gate.features.size()},
                       {"layers", std::move(layers)}});
  }
  return {{"features", model.features.size()},
          {"direct", model.direct.size()},
          {"coefficients", model.columns},
          {"parameters", model.parameter_count()},
          {"regions", std::move(regions)}};
}

// An object of bounded depth whatever the archive holds, else null: files come from anyone, and printing JSON recurses.
Json object_in(const std::string& text) {
  const auto shallow = [](int depth, Json::parse_event_t, Json&) { return depth < 32; };
  Json json = Json::parse(text, shallow, false);
  return json.is_object() ? json : Json();
}

Json provenance_of(const Archive& archive) {
  const Json json = object_in(archive.model.provenance);
  return json.is_null() ? Json::object() : json;
}

// A line of the table of errors, where `json` has the figures of one.
void add_errors(Table& table, const std::string& what, const Json& json) {
  if (!json.is_object()) return;
  std::vector<std::string> row = {what};
  const auto frames = json.find("frames");
  row.push_back(frames != json.end() && frames->is_number_unsigned() ? std::to_string(frames->get<std::uint64_t>())
                                                                     : "");
  for (const char* key : {"mse", "rms", "mean", "p99", "max", "mfm"}) {
    const auto figure = json.find(key);
    row.push_back(figure != json.end() && figure->is_number() ? format("%.3g", figure->get<double>()) : "");
  }
  table.add(std::move(row));
}

// Lines named after `key` of each object of a list.
void add_list(Table& table, const char* what, const Json& json, const char* list, const char* key) {
  const auto found = json.find(list);
  if (found == json.end() || !found->is_array()) return;
  for (const Json& one : *found)
    if (one.is_object() && one.contains(key) && one[key].is_string())
      add_errors(table, what + one[key].get<std::string>(), one);
}

}  // namespace

std::string inspect_json(const std::string& path, const Archive& archive, std::uint64_t total_bytes,
                         std::uint64_t runtime_bytes) {
  const PackedModel& model = archive.model;
  Json bytes = {{"total", total_bytes}};
  for (const SectionInfo& section : archive.sections) bytes[section.name] = section.stored_bytes;
  Json controls = Json::array();
  for (const Control& control : model.schema.controls)
    controls.push_back({{"name", control.name},
                        {"min", control.minimum},
                        {"max", control.maximum},
                        {"default", control.rest},
                        {"group", control.group}});
  const std::string recipe = recipe_of(archive);
  const Json json = {
      {"archive", path},
      {"format_version", archive.format_version},
      {"name", model.schema.name},
      {"units", model.schema.units},
      {"up_axis", model.schema.up_axis},
      {"vertices", model.rest.vertex_count()},
      {"controls", model.schema.control_count()},
      {"polygons", model.rest.polygon_sizes.size()},
      {"diagonal", model.rest.diagonal()},
      {"recipe", recipe.empty() ? Json() : Json(recipe)},
      {"bytes", std::move(bytes)},
      {"runtime_bytes", runtime_bytes},
      {"certificate", object_in(archive.text.certificate)},
      {"network", network_graph(model)},
      {"basis", {{"rows", model.rest.points.size()}, {"columns", model.columns}, {"values", model.value_count()}}},
      {"control_list", std::move(controls)},
      {"licence", archive.text.licence},
      {"proof", {{"poses", archive.proof.hashes.size()}, {"vertices", archive.proof.vertices.size()}}},
      {"notes", archive.notes},
      {"provenance", provenance_of(archive)}};
  return json_text(json);
}

std::string verify_json(const std::string& archive, const VerifyReport& report) {
  return json_text({{"archive", archive},
                    {"bytes", report.bytes},
                    {"poses", report.poses},
                    {"vertices", report.vertices},
                    {"certificate", object_in(report.certificate)}});
}

std::string name_of(Activation activation) {
  switch (activation) {
    case Activation::linear:
      return "linear";
    case Activation::relu:
      return "relu";
    case Activation::tanh:
      return "tanh";
    case Activation::silu:
      return "silu";
  }
  return "";
}

std::string certificate_text(const Archive& archive) {
  const Json json = object_in(archive.text.certificate);
  if (json.is_null()) return "";
  Table table({"errors over the diagonal", "frames", "mse", "rms", "mean", "p99", "max", "mfm"});
  add_errors(table, "trained on", json.value("dependency", Json()));
  const Json unseen = json.value("independent", Json());
  add_errors(table, "unseen", unseen);
  if (unseen.is_object()) {
    add_list(table, "  kind ", unseen, "kinds", "kind");
    add_list(table, "  clip ", unseen, "clips", "name");
    add_list(table, "  region ", unseen, "regions", "name");
  }
  for (const char* key : {"quantisation", "repacked", "bound"}) add_errors(table, key, json.value(key, Json()));
  std::string text = table.text();
  const Json normals = unseen.is_object() ? unseen.value("normals", Json()) : Json();
  if (normals.is_object() && normals.contains("rms_degrees") && normals["rms_degrees"].is_number())
    text += format("normals, unseen: %.3g degrees (root mean square)\n", normals["rms_degrees"].get<double>());
  return text;
}

std::string provenance_text(const Archive& archive) {
  const Json provenance = provenance_of(archive);
  std::string text;
  for (const auto& [key, value] : provenance.items())
    text += format(
        "%s: %s\n", key.c_str(),
        (value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace))
            .c_str());
  return text;
}

std::string recipe_of(const Archive& archive) {
  const Json provenance = provenance_of(archive);
  const auto found = provenance.find("recipe");
  return found != provenance.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace fb::tool
