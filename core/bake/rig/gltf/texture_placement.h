// How KHR_texture_transform moves the textures of a material.
#pragma once

#include <array>
#include <optional>

namespace tinygltf {
struct Material;
}  // namespace tinygltf

namespace fb::bake {

// Texture coordinates of a texture are offset + scale x those of the mesh, as glTF counts them: v downwards.
struct TexturePlacement {
  std::array<double, 2> offset = {0, 0}, scale = {1, 1};
  auto operator<=>(const TexturePlacement&) const = default;
};

// That of all textures of a material which use the first texture coordinates; nothing where they differ, or where one
// is rotated, or not finite.
std::optional<TexturePlacement> common_placement(const tinygltf::Material& material);

}  // namespace fb::bake
