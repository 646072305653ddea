// Feeds arbitrary bytes to what decodes textures of materials, which archives bring from anywhere.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "render/texture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  constexpr int most_pixels = 64;
  const auto texture = fb::tool::decode_texture(std::as_bytes(std::span(bytes, size)), most_pixels);
  if (!texture) return 0;
  if (texture->width < 1 || texture->width > most_pixels || texture->height < 1 || texture->height > most_pixels ||
      texture->pixels.size() != std::size_t(texture->width) * std::size_t(texture->height))
    std::abort();
  for (const float u : {-0.5f, 0.3f, 1.5f})
    for (const auto wrap : {fb::tool::TextureWrap::repeat, fb::tool::TextureWrap::clamp, fb::tool::TextureWrap::mirror})
      texture->at(u, 1 - u, wrap, wrap);
  return 0;
}
