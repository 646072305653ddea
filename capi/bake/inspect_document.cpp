#include <nlohmann/json.hpp>

#include "bake/documents.h"
#include "bake/rig/character_json.h"
#include "bake/rig/json_field.h"
#include "bake/rights/binding_rights.h"

namespace fb::capi {
namespace {

using Json = nlohmann::ordered_json;
using archive::Archive;

const char* name_of(Activation activation) {
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

Json network_of(const PackedModel& model) {
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

Json control_list(const RigSchema& schema) {
  Json controls = Json::array();
  for (const Control& control : schema.controls) {
    Json& json = controls.emplace_back(Json{{"name", control.name},
                                            {"min", control.minimum},
                                            {"max", control.maximum},
                                            {"default", control.rest},
                                            {"group", control.group}});
    bake::write_labels(control, json);
  }
  return controls;
}

Json skin_of(const Skin& skin, const Mesh& rest) {
  std::size_t skinned = 0;
  for (std::size_t v = 0; v < rest.surface_vertex_count(); ++v) skinned += skin.count(v) > 0;
  return {{"influences", skin.influences}, {"vertices", skinned}};
}

Json provenance_of(const Archive& archive) {
  const Json json = bake::object_in(archive.model.provenance);
  return json.is_null() ? Json::object() : json;
}

}  // namespace

std::string inspect_json(const std::string& path, const Archive& archive, std::uint64_t total_bytes,
                         std::uint64_t runtime_bytes) {
  const PackedModel& model = archive.model;
  Json bytes = {{"total", total_bytes}};
  for (const archive::SectionInfo& section : archive.sections) bytes[section.name] = section.stored_bytes;
  const std::string recipe = recipe_of(archive);
  Json document = {
      {"archive", path},
      {"format_version", archive.format_version},
      {"name", model.schema.name},
      {"units", model.schema.units},
      {"up_axis", model.schema.up_axis},
      {"vertices", model.rest.surface_vertex_count()},
      {"controls", model.schema.control_count()},
      {"polygons", model.rest.polygon_sizes.size()},
      {"diagonal", model.rest.diagonal()},
      {"recipe", recipe.empty() ? Json() : Json(recipe)},
      {"learned", provenance_of(archive).value("learned", Json())},
      {"bytes", std::move(bytes)},
      {"runtime_bytes", runtime_bytes},
      {"certificate", bake::object_in(archive.text.certificate)},
      {"network", network_of(model)},
      {"basis", {{"rows", model.rest.points.size()}, {"columns", model.columns}, {"values", model.value_count()}}},
      {"control_list", control_list(model.schema)},
      {"licence", archive.text.licence},
      {"proof", {{"poses", archive.proof.hashes.size()}, {"vertices", archive.proof.vertices.size()}}},
      {"notes", archive.notes},
      {"provenance", provenance_of(archive)}};
  const auto size_of = [&](std::size_t image, Json& json) {
    json["bytes"] = model.character.images[image].bytes.size();
  };
  bake::write_character(model.rest.parts, model.character, size_of, document);
  bake::write_channels(model.schema.channels, document);
  for (const ExactPose& pose : model.exact) document["exact_poses"].push_back({{"name", pose.name}});
  if (const Skin& skin = model.character.skin; skin.influences > 0) document["skin"] = skin_of(skin, model.rest);
  bake::write_driven_joints(model.rest.driven.joints, document);
  if (const Skin& skin = model.rest.driven.skin; skin.influences > 0)
    document["driven_skin"] = skin_of(skin, model.rest);
  for (std::size_t k = 1; k <= model.levels.size(); ++k) {
    const DetailLevel& level = model.levels[k - 1];
    document["levels"].push_back({{"level", k},
                                  {"vertices", level.vertices},
                                  {"polygons", level.polygon_sizes.size()},
                                  {"coefficients", coefficients_of(model, level)}});
  }
  if (!model.character.about.empty()) document["about"] = bake::object_in(model.character.about);
  if (const bake::Rights rights = bake::rights_in(model.character.about); !rights.empty())
    document["rights"] = bake::rights_document(rights, today());
  if (!model.character.thumbnail.empty()) document["thumbnail"] = {{"bytes", model.character.thumbnail.size()}};
  return json_text(document);
}

std::string recipe_of(const Archive& archive) {
  const Json provenance = provenance_of(archive);
  const auto found = provenance.find("recipe");
  return found != provenance.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace fb::capi
