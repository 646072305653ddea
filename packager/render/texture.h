#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace fb::tool {

// How a texture goes on beyond its borders.
enum class TextureWrap { repeat, clamp, mirror };

// A picture that colours a surface: sRGB and alpha, rows from top to bottom.
struct Texture {
  int width = 0, height = 0;
  std::vector<std::array<std::uint8_t, 4>> pixels = {};

  // Linear red, green and blue, and alpha, between pixels mixed by how near they are. u to the right and v upwards,
  // from 0 to 1.
  std::array<float, 4> at(float u, float v, TextureWrap wrap_u, TextureWrap wrap_v) const;
};

// Decodes a file (read_picture_file), and halves the picture until it has at most `most_pixels` along each edge: a
// small picture of the surface then shows means of its pixels.
std::optional<Texture> decode_texture(std::span<const std::byte> file, int most_pixels);

}  // namespace fb::tool
