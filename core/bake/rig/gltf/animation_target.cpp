#include "bake/rig/gltf/animation_target.h"

#include <tiny_gltf.h>

#include <charconv>
#include <string_view>
#include <vector>

namespace fb::bake {
namespace {

// "/nodes/3/weights": "nodes", "3", "weights".
std::vector<std::string_view> split_pointer(std::string_view pointer) {
  std::vector<std::string_view> parts;
  while (pointer.starts_with('/')) {
    pointer.remove_prefix(1);
    parts.push_back(pointer.substr(0, pointer.find('/')));
    pointer.remove_prefix(parts.back().size());
  }
  return parts;
}

std::optional<int> index_from(std::string_view text) {
  int index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || end != text.data() + text.size() || index < 0) return std::nullopt;
  return index;
}

AnimationTarget target_of_pointer(const std::string& pointer) {
  AnimationTarget target{pointer, -1, -1, std::nullopt};
  const std::vector<std::string_view> parts = split_pointer(pointer);
  if (parts.size() != 3 && parts.size() != 4) return target;
  const std::optional<int> index = index_from(parts[1]);
  const bool of_node = parts[0] == "nodes", weights = parts[2] == "weights";
  if (!index || !(of_node || (parts[0] == "meshes" && weights)) || (parts.size() == 4 && !weights)) return target;
  if (parts.size() == 4) {
    const std::optional<int> weight = index_from(parts[3]);
    if (!weight) return target;
    target.weight = static_cast<std::size_t>(*weight);
  }
  (of_node ? target.node : target.mesh) = *index;
  target.path = parts[2];
  return target;
}

}  // namespace

AnimationTarget target_of(const tinygltf::AnimationChannel& channel) {
  const auto found = channel.target_extensions.find("KHR_animation_pointer");
  if (found == channel.target_extensions.end()) return {channel.target_path, channel.target_node, -1, std::nullopt};
  const tinygltf::Value& pointer = found->second;
  if (!pointer.IsObject() || !pointer.Get("pointer").IsString()) return {"", -1, -1, std::nullopt};
  return target_of_pointer(pointer.Get("pointer").Get<std::string>());
}

}  // namespace fb::bake
