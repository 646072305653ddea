#include "bake/rig/gltf/texture_placement.h"

#include <tiny_gltf.h>

#include <cmath>

namespace fb::bake {
namespace {

// Two numbers of a transform, such as its offset.
bool read_pair(const tinygltf::Value& transform, const char* key, std::array<double, 2>& to) {
  if (!transform.Has(key)) return true;
  const tinygltf::Value& pair = transform.Get(key);
  if (!pair.IsArray() || pair.ArrayLen() != 2) return false;
  for (int i = 0; i < 2; ++i) {
    if (!pair.Get(i).IsNumber() || !std::isfinite(pair.Get(i).GetNumberAsDouble())) return false;
    to[static_cast<std::size_t>(i)] = pair.Get(i).GetNumberAsDouble();
  }
  return true;
}

// Nothing where it rotates. `coordinates`: which the texture uses.
std::optional<TexturePlacement> placement_of(const tinygltf::ExtensionMap& extensions, int& coordinates) {
  TexturePlacement placement;
  const auto found = extensions.find("KHR_texture_transform");
  if (found == extensions.end() || !found->second.IsObject()) return placement;
  const tinygltf::Value& transform = found->second;
  if (transform.Get("texCoord").IsInt()) coordinates = transform.Get("texCoord").GetNumberAsInt();
  const tinygltf::Value& rotation = transform.Get("rotation");
  if (transform.Has("rotation") && !(rotation.IsNumber() && rotation.GetNumberAsDouble() == 0)) return std::nullopt;
  if (!read_pair(transform, "offset", placement.offset) || !read_pair(transform, "scale", placement.scale))
    return std::nullopt;
  return placement;
}

}  // namespace

std::optional<TexturePlacement> common_placement(const tinygltf::Material& material) {
  std::optional<TexturePlacement> common;
  bool agree = true;
  const auto add = [&](const auto& info) {
    int coordinates = info.texCoord;
    const auto placement = info.index < 0 ? std::nullopt : placement_of(info.extensions, coordinates);
    if (info.index < 0 || coordinates != 0) return;
    agree = agree && placement && (!common || *common == *placement);
    common = placement;
  };
  add(material.pbrMetallicRoughness.baseColorTexture);
  add(material.pbrMetallicRoughness.metallicRoughnessTexture);
  add(material.normalTexture);
  add(material.occlusionTexture);
  add(material.emissiveTexture);
  if (!agree) return std::nullopt;
  return common ? common : TexturePlacement{};
}

}  // namespace fb::bake
