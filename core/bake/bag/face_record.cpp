#include "bake/bag/face_record.h"

#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/bag/check_files.h"
#include "bake/measure/certificate.h"
#include "bake/measure/verify.h"
#include "bake/rig/json_field.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Json = nlohmann::ordered_json;
using Fields = std::vector<std::pair<std::string, std::string>>;

// object_in has limited how deep it lies.
void add_fields(const Json& json, const std::string& name, Fields& fields) {
  if (json.is_object() && !json.empty()) {
    for (const auto& [key, value] : json.items()) add_fields(value, name.empty() ? key : name + "." + key, fields);
  } else if (json.is_array() && !json.empty()) {
    for (std::size_t i = 0; i < json.size(); ++i) add_fields(json[i], name + format("[%zu]", i), fields);
  } else {
    fields.emplace_back(name, json.is_string() ? json.get<std::string>() : json.dump());
  }
}

// Texts of archives need not be JSON to a reader; what is none is kept as one text.
Fields fields_in(const std::string& text) {
  Fields fields;
  if (text.empty()) return fields;
  const Json object = object_in(text);
  if (object.is_object())
    add_fields(object, "", fields);
  else
    fields.emplace_back("text", text);
  return fields;
}

std::string value_in(const Fields& fields, const std::string& key) {
  for (const auto& [name, value] : fields)
    if (name == key) return value;
  return "";
}

}  // namespace

std::string FaceRecord::right(const char* key) const {
  return value_in(about, std::string("rights.") + key);
}

FaceRecord read_face_record(std::span<const std::byte> archive, const std::string& name) {
  const archive::Archive read = archive::read_archive(archive);
  const VerifyReport verified = verify_archive(read, archive.size());
  FaceRecord record;
  record.name = name;
  record.file = archives_prefix + name;
  record.character = read.model.schema.name;
  record.version = format("%u.%u", read.format_version / 1000, read.format_version % 1000);
  record.licence = read.text.licence;
  record.certificate = certificate_summary(read.text.certificate);
  record.poses = verified.poses;
  record.vertices = verified.vertices;
  record.about = fields_in(read.model.character.about);
  record.provenance = fields_in(read.model.provenance);
  record.creator = value_in(record.provenance, "creator");
  record.created = value_in(record.provenance, "created");
  return record;
}

}  // namespace fb::bake
