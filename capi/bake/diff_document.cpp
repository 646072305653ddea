#include <nlohmann/json.hpp>

#include "bake/documents.h"
#include "bake/rig/json_field.h"

namespace fb::capi {
namespace {

using Json = nlohmann::ordered_json;
using namespace fb::bake;

Json change(const Json& before, const Json& now) {
  return {{"before", before}, {"now", now}};
}

Json declaration_of(const Control& control) {
  return {{"min", control.minimum}, {"max", control.maximum}, {"default", control.rest}, {"group", control.group}};
}

// "max" and "mse" are over the diagonal, "distance" is "max" in units.
Json figures(double mse, double max, std::size_t vertex, const std::string& place, double diagonal) {
  return {{"mse", mse}, {"max", max}, {"distance", max * diagonal}, {"vertex", vertex}, {"place", place}};
}

Json control_list(const FaceDifference& difference) {
  Json list = Json::array();
  for (const ControlDifference& control : difference.controls) {
    Json json = {{"name", control.name}, {"value", control.value}};
    json.update(figures(control.mse, control.max, control.vertex, control.place, difference.diagonal));
    const Json before = declaration_of(control.before), now = declaration_of(control.now);
    json["declared"] = before == now ? Json() : change(before, now);
    list.push_back(std::move(json));
  }
  return list;
}

Json region_list(const FaceDifference& difference) {
  Json list = Json::array();
  for (const PartDifference& part : difference.parts)
    list.push_back({{"title", part.title},
                    {"vertices", part.vertices},
                    {"max", part.max},
                    {"distance", part.max * difference.diagonal}});
  return list;
}

// The values of two objects that differ, by key, objects within them as "outer.inner".
void add_changes(Json& to, const std::string& prefix, const Json& before, const Json& now) {
  const auto compare = [&](const std::string& key, const Json& a, const Json& b) {
    if (a.is_object() && b.is_object())
      add_changes(to, prefix + key + ".", a, b);
    else if (a != b)
      to[prefix + key] = change(a, b);
  };
  for (const auto& [key, value] : before.items()) compare(key, value, now.contains(key) ? now.at(key) : Json());
  for (const auto& [key, value] : now.items())
    if (!before.contains(key)) compare(key, Json(), value);
}

Json changes(const std::string& before, const std::string& now) {
  const auto object = [](const std::string& text) {
    Json json = object_in(text);
    return json.is_null() ? Json::object() : json;
  };
  Json found = Json::object();
  add_changes(found, "", object(before), object(now));
  return found;
}

}  // namespace

std::string diff_json(const std::string& before, const archive::Archive& old_archive, const std::string& now,
                      const archive::Archive& new_archive, const FaceDifference& difference) {
  const PackedModel &old_model = old_archive.model, &model = new_archive.model;
  const auto errors = [&](const Errors& e, const std::string& place) {
    if (!difference.same_vertices) return Json();
    Json json = figures(e.mse, e.max, e.worst_vertex, place, difference.diagonal);
    json["frames"] = e.frames;
    return json;
  };
  return json_text({{"before", before},
                    {"now", now},
                    {"equal", difference.equal},
                    {"units", model.schema.units},
                    {"diagonal", difference.diagonal},
                    {"schema", difference.schema},
                    {"controls_added", difference.added},
                    {"controls_removed", difference.removed},
                    {"vertices", change(old_model.rest.surface_vertex_count(), model.rest.surface_vertex_count())},
                    {"same_polygons", difference.same_polygons},
                    {"same_texture_coordinates", difference.same_uvs},
                    {"same_exact_poses", difference.same_exact_poses},
                    {"rest", errors(difference.rest, difference.rest_place)},
                    {"random", errors(difference.random, difference.random_place)},
                    {"controls", control_list(difference)},
                    {"regions", region_list(difference)},
                    {"provenance", changes(old_model.provenance, model.provenance)},
                    {"about", changes(old_model.character.about, model.character.about)},
                    {"certificate", changes(old_archive.text.certificate, new_archive.text.certificate)},
                    {"same_licence", old_archive.text.licence == new_archive.text.licence}});
}

}  // namespace fb::capi
