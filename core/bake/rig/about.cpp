#include "bake/rig/about.h"

#include <nlohmann/json.hpp>

#include "bake/rig/json_field.h"
#include "bake/rights/rights.h"
#include "bake/rights/rights_terms.h"
#include "base/status.h"
#include "model/character.h"

namespace fb::bake {
namespace {

using nlohmann::ordered_json;

void check_fields(const ordered_json& about) {
  if (!about.is_object()) fail(Status::bad_data, "about: is no object");
  for (const char* key : {"name", "author", "contact", "rig", "rig_version", "created"})
    if (about.contains(key) && !about[key].is_string() && !about[key].is_null())
      fail(Status::bad_data, "about: %s is no string", key);
  if (about.contains("rights") && !about["rights"].is_null()) check_rights(about["rights"]);
}

}  // namespace

std::string about_text(const ordered_json& about) {
  check_fields(about);
  ordered_json said = ordered_json::object();
  said.merge_patch(about);  // without fields that are null
  if (said.empty()) return "";
  std::string text;
  try {
    text = said.dump();
  } catch (const ordered_json::exception&) {
    fail(Status::bad_data, "about: a text is not UTF-8");
  }
  if (text.size() > most_about_bytes)
    fail(Status::limit, "about has %zu bytes; it may have %zu", text.size(), most_about_bytes);
  return text;
}

ordered_json parse_about(const std::string& text) {
  ordered_json about = parse_json<ordered_json>(text, "about");
  check_fields(about);
  return about;
}

std::string merged_about(const std::string& of_source, const std::string& given) {
  ordered_json about = of_source.empty() ? ordered_json::object() : parse_json<ordered_json>(of_source, "about");
  if (!about.is_object()) fail(Status::bad_data, "about: is no object");
  if (!given.empty()) about.merge_patch(parse_about(given));
  return about_text(about);
}

std::string take_licence(std::string& about) {
  if (about.empty()) return "";
  ordered_json json = parse_about(about);
  if (!json.contains("rights") || !json["rights"].contains("licence")) return "";
  const std::string licence = json["rights"]["licence"];
  json["rights"].erase("licence");
  if (json["rights"].empty()) json.erase("rights");
  about = about_text(json);
  return licence;
}

bool forbids_learning(const std::string& about) {
  return rights_in(about).learning_permission() == Permission::not_allowed;
}

}  // namespace fb::bake
