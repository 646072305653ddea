// Small pictures of few colours.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

#include "render/palette.h"
#include "render/palette_png.h"
#include "render/texture.h"

using namespace fb::tool;

namespace {

// Distance of the channel that is furthest off, of the worst pixel and on average.
std::array<double, 2> errors_of(const Image& image, const Palette& palette) {
  double worst = 0, sum = 0;
  for (std::size_t p = 0; p < image.pixels.size(); ++p) {
    const Rgb &is = palette.colours.at(palette.indices.at(p)), &was = image.pixels[p];
    const double off = std::max({std::abs(is.r - was.r), std::abs(is.g - was.g), std::abs(is.b - was.b)});
    worst = std::max(worst, off);
    sum += off;
  }
  return {worst, sum / static_cast<double>(image.pixels.size())};
}

// 16,384 pixels, all of different colours, as no picture of a face has.
Image many_colours() {
  Image image(128, 128);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      const auto channel = [](int value) { return static_cast<std::uint8_t>(value); };
      image.at(x, y) = {channel(2 * x), channel(2 * y), channel((x + y) % 7 * 30)};
    }
  return image;
}

}  // namespace

TEST_CASE("an image of few colours keeps them") {
  Image image(16, 16, {250, 130, 10});
  for (int x = 0; x < 16; ++x) image.at(x, 3) = {static_cast<std::uint8_t>(16 * x), 0, 255};
  const Palette palette = palette_of(image);
  CHECK(palette.colours.size() == 17);
  CHECK(errors_of(image, palette)[0] == 0);
}

TEST_CASE("shades of a few hues become means of pixels that agree in five bits") {
  Image image(64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto light = static_cast<std::uint8_t>(3 * x + y / 2);
      image.at(x, y) = {light, static_cast<std::uint8_t>(light / 2), static_cast<std::uint8_t>(light / 3 + y / 8)};
    }
  const Palette palette = palette_of(image);
  CHECK(palette.colours.size() > 60);
  CHECK(errors_of(image, palette)[0] < 8);
}

TEST_CASE("an image of many colours becomes one of 256 that are near them, those with many pixels most") {
  Image image = many_colours();
  const Palette palette = palette_of(image);
  CHECK(palette.colours.size() == 256);
  const auto [worst, mean] = errors_of(image, palette);
  CHECK(worst < 48);
  CHECK(mean < 16);
  for (int y = 32; y < 128; ++y)
    for (int x = 0; x < 128; ++x) image.at(x, y) = {static_cast<std::uint8_t>(100 + x % 4), 60, 40};
  CHECK(errors_of(image, palette_of(image))[1] < 0.6 * mean);
}

TEST_CASE("a palette PNG has the picture, in a byte a pixel at most") {
  const Image image = many_colours();
  const Palette palette = palette_of(image);
  const std::vector<std::byte> png = palette_png(image);
  CHECK(png.size() < 128 * 128 + 1200);
  const auto decoded = decode_texture(png, 128);
  REQUIRE(decoded);
  REQUIRE(decoded->pixels.size() == image.pixels.size());
  std::size_t different = 0;
  for (std::size_t p = 0; p < image.pixels.size(); ++p) {
    const Rgb& colour = palette.colours[palette.indices[p]];
    const auto& is = decoded->pixels[p];
    different += is[0] != colour.r || is[1] != colour.g || is[2] != colour.b;
  }
  CHECK(different == 0);
}
