#include "bake/rig/gltf/loadable_file.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "bake/rig/gltf/glb_chunks.h"
#include "bake/rig/gltf/meshopt_views.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using nlohmann::json;

// An object's member; null where it is none, or has none.
const json& member_of(const json& object, const char* key) {
  static const json none;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : none;
}

// Whether a buffer holds nothing that is read here: one without data, or that says so.
bool is_fallback(const json& buffer, std::size_t index, bool binary) {
  if (!buffer.is_object()) return false;
  const json& extensions = member_of(buffer, "extensions");
  for (auto one = extensions.begin(); extensions.is_object() && one != extensions.end(); ++one)
    if (is_meshopt_extension(one.key()) && member_of(*one, "fallback") == true) return true;
  return !buffer.contains("uri") && !(binary && index == 0);
}

bool shorten_fallback_buffers(json& file, bool binary) {
  if (!member_of(file, "buffers").is_array()) return false;
  bool changed = false;
  std::size_t index = 0;
  for (json& buffer : file["buffers"])
    if (is_fallback(buffer, index++, binary)) {
      buffer = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
      changed = true;
    }
  return changed;
}

bool give_indices_a_view(json& file) {
  if (!member_of(file, "accessors").is_array()) return false;
  bool changed = false;
  for (const json& mesh : member_of(file, "meshes"))
    for (const json& primitive : member_of(mesh, "primitives")) {
      const json& draco = member_of(member_of(primitive, "extensions"), "KHR_draco_mesh_compression");
      const json& indices = member_of(primitive, "indices");
      if (!draco.is_object() || !indices.is_number_unsigned() || indices >= file["accessors"].size()) continue;
      json& accessor = file["accessors"][indices.get<std::size_t>()];
      if (!accessor.is_object() || accessor.contains("bufferView")) continue;
      accessor["bufferView"] = 0;
      changed = true;
    }
  return changed;
}

bool give_pointers_a_node(json& file) {
  if (!member_of(file, "animations").is_array()) return false;
  bool changed = false;
  for (json& animation : file["animations"]) {
    if (!member_of(animation, "channels").is_array()) continue;
    for (json& channel : animation["channels"]) {
      const json& target = member_of(channel, "target");
      if (!target.is_object() || target.contains("node") || !target.contains("extensions")) continue;
      channel["target"]["node"] = 0;
      changed = true;
    }
  }
  return changed;
}

// Whether a URI, of whatever, needs encode_uris.
bool has_odd_uri(std::string_view text) {
  constexpr std::string_view key = "\"uri\"";
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at)) {
    at = text.find('"', at + key.size());
    if (at == std::string_view::npos) return false;
    const std::string_view uri = text.substr(at + 1, text.find('"', at + 1) - at - 1);
    if (!uri.starts_with("data:") && uri.find_first_of("+%\\") != std::string_view::npos) return true;
  }
  return false;
}

bool encode_uris(json& file) {
  if (!member_of(file, "buffers").is_array()) return false;
  bool changed = false;
  for (json& buffer : file["buffers"]) {
    const auto* uri = member_of(buffer, "uri").get_ptr<const std::string*>();
    if (!uri || uri->starts_with("data:")) continue;
    std::string encoded;
    for (const char c : *uri)
      encoded += c == '+' || c == '%' ? format("%%%02x", static_cast<unsigned>(c)) : std::string(1, c);
    changed |= encoded != *uri;
    buffer["uri"] = encoded;
  }
  return changed;
}

}  // namespace

std::optional<std::vector<std::byte>> loadable_file(std::span<const std::byte> bytes, bool binary) {
  const std::string_view text = json_of_gltf(bytes, binary);
  const bool compressed = text.find("_compression") != std::string_view::npos;
  if (!compressed && text.find("KHR_animation_pointer") == std::string_view::npos && !has_odd_uri(text))
    return std::nullopt;
  json file = json::parse(text, nullptr, false);
  if (!file.is_object()) return std::nullopt;
  const bool shortened = compressed && shorten_fallback_buffers(file, binary),
             given = compressed && give_indices_a_view(file), aimed = give_pointers_a_node(file),
             encoded = encode_uris(file);
  if (!shortened && !given && !aimed && !encoded) return std::nullopt;
  return with_json(bytes, binary, file.dump(-1, ' ', false, json::error_handler_t::replace));
}

}  // namespace fb::bake
