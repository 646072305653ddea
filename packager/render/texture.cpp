#include "render/texture.h"

#include <algorithm>
#include <cmath>

#include "render/picture_file.h"
#include "render/shading.h"

namespace fb::tool {
namespace {

using Pixel = std::array<std::uint8_t, 4>;

const std::array<float, 256>& linear_values() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = from_srgb({static_cast<float>(i) / 255, 0, 0}).x;
    return values;
  }();
  return table;
}

std::array<float, 4> linear(const Pixel& pixel) {
  const auto& table = linear_values();
  return {table[pixel[0]], table[pixel[1]], table[pixel[2]], static_cast<float>(pixel[3]) / 255};
}

// Half as large, each pixel the mean of four.
Texture halved(const Texture& texture) {
  Texture half = {std::max(1, texture.width / 2), std::max(1, texture.height / 2)};
  half.pixels.reserve(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      std::array<float, 4> sum = {};
      for (int corner = 0; corner < 4; ++corner) {
        const int column = std::min(2 * x + corner % 2, texture.width - 1),
                  row = std::min(2 * y + corner / 2, texture.height - 1);
        const auto value =
            linear(texture.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) +
                                  static_cast<std::size_t>(column)]);
        for (std::size_t i = 0; i < 4; ++i) sum[i] += 0.25f * value[i];
      }
      const Rgb colour = to_srgb({sum[0], sum[1], sum[2]});
      half.pixels.push_back({colour.r, colour.g, colour.b, static_cast<std::uint8_t>(std::lround(255 * sum[3]))});
    }
  return half;
}

// A texture coordinate that can be counted in pixels; 0 for what is not a number.
float countable(float coordinate) {
  constexpr float most_periods = 1e4f;
  return std::isfinite(coordinate) ? std::clamp(coordinate, -most_periods, most_periods) : 0.0f;
}

// The pixel that a whole number of pixels from the border shows.
int wrapped(int pixel, int count, TextureWrap wrap) {
  if (wrap == TextureWrap::clamp) return std::clamp(pixel, 0, count - 1);
  const int period = wrap == TextureWrap::mirror ? 2 * count : count;
  const int within = (pixel % period + period) % period;
  return within < count ? within : period - 1 - within;
}

}  // namespace

std::array<float, 4> Texture::at(float u, float v, TextureWrap wrap_u, TextureWrap wrap_v) const {
  const float x = countable(u) * static_cast<float>(width) - 0.5f,
              y = (1 - countable(v)) * static_cast<float>(height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  std::array<float, 4> sum = {};
  for (int corner = 0; corner < 4; ++corner) {
    const int dx = corner % 2, dy = corner / 2;
    const int column = wrapped(static_cast<int>(left) + dx, width, wrap_u),
              row = wrapped(static_cast<int>(top) + dy, height, wrap_v);
    const float share = (dx ? x - left : 1 - (x - left)) * (dy ? y - top : 1 - (y - top));
    const auto value = linear(
        pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)]);
    for (std::size_t i = 0; i < 4; ++i) sum[i] += share * value[i];
  }
  return sum;
}

std::optional<Texture> decode_texture(std::span<const std::byte> file, int most_pixels) {
  std::optional<Texture> texture = read_picture_file(file);
  while (texture && std::max(texture->width, texture->height) > most_pixels) texture = halved(*texture);
  return texture;
}

}  // namespace fb::tool
