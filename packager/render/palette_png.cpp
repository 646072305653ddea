#include "render/palette_png.h"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <map>
#include <span>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::size_t most_colours = 256;

struct Palette {
  std::vector<Rgb> colours;           // by the kept bits of green, red and blue, so that neighbours are alike
  std::vector<std::uint8_t> indices;  // of each pixel
};

// The kept bits of a pixel; green first, which is brightest.
std::uint32_t key_of(const Rgb& pixel, int dropped) {
  const auto kept = [&](std::uint8_t channel) { return std::uint32_t{channel} >> dropped; };
  return kept(pixel.g) << 16 | kept(pixel.r) << 8 | kept(pixel.b);
}

// Nothing if there would be too many colours.
Palette palette_of(const Image& image, int dropped) {
  struct Sum {
    std::uint64_t r = 0, g = 0, b = 0, count = 0;
    std::uint8_t index = 0;
  };
  std::map<std::uint32_t, Sum> sums;
  for (const Rgb& pixel : image.pixels) {
    Sum& sum = sums[key_of(pixel, dropped)];
    sum.r += pixel.r, sum.g += pixel.g, sum.b += pixel.b, ++sum.count;
  }
  Palette palette;
  if (sums.size() > most_colours) return palette;
  for (auto& [key, sum] : sums) {
    sum.index = static_cast<std::uint8_t>(palette.colours.size());
    const auto mean = [n = sum.count](std::uint64_t total) { return static_cast<std::uint8_t>((total + n / 2) / n); };
    palette.colours.push_back({mean(sum.r), mean(sum.g), mean(sum.b)});
  }
  for (const Rgb& pixel : image.pixels) palette.indices.push_back(sums[key_of(pixel, dropped)].index);
  return palette;
}

// PNG's filters 0 to 2: none, and the difference from the pixel on the left or above.
std::vector<std::uint8_t> filtered(const Palette& palette, std::size_t width, std::uint8_t filter) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < palette.indices.size(); ++i) {
    if (i % width == 0) bytes.push_back(filter);
    const std::uint8_t left = i % width > 0 ? palette.indices[i - 1] : 0;
    const std::uint8_t above = i >= width ? palette.indices[i - width] : 0;
    const std::uint8_t prediction = filter == 0 ? 0 : filter == 1 ? left : above;
    bytes.push_back(static_cast<std::uint8_t>(palette.indices[i] - prediction));
  }
  return bytes;
}

std::vector<std::byte> deflated(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::byte> packed(size);
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, bytes.data(), static_cast<uLong>(bytes.size()),
                Z_BEST_COMPRESSION) != Z_OK)
    fail(Status::out_of_memory, "no memory to compress an image");
  packed.resize(size);
  return packed;
}

void add_number(std::vector<std::byte>& to, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) to.push_back(std::byte(number >> shift & 0xff));
}

void add_chunk(std::vector<std::byte>& png, const char (&type)[5], std::span<const std::byte> contents) {
  add_number(png, static_cast<std::uint32_t>(contents.size()));
  const std::size_t begin = png.size();
  for (std::size_t i = 0; i < 4; ++i) png.push_back(std::byte(type[i]));
  png.insert(png.end(), contents.begin(), contents.end());
  add_number(png, static_cast<std::uint32_t>(
                      crc32(0, reinterpret_cast<const Bytef*>(&png[begin]), static_cast<uInt>(png.size() - begin))));
}

}  // namespace

std::vector<std::byte> palette_png(const Image& image) {
  Palette palette;
  for (int dropped = 2; palette.colours.empty(); ++dropped) palette = palette_of(image, dropped);
  std::vector<std::byte> pixels;
  for (const std::uint8_t filter : {0, 1, 2}) {
    std::vector<std::byte> packed = deflated(filtered(palette, static_cast<std::size_t>(image.width), filter));
    if (pixels.empty() || packed.size() < pixels.size()) pixels = std::move(packed);
  }
  std::vector<std::byte> header;
  add_number(header, static_cast<std::uint32_t>(image.width));
  add_number(header, static_cast<std::uint32_t>(image.height));
  for (const int field : {8, 3, 0, 0, 0}) header.push_back(std::byte(field));  // bits, palette, standard methods
  std::vector<std::byte> colours;
  for (const Rgb& colour : palette.colours)
    for (const std::uint8_t channel : {colour.r, colour.g, colour.b}) colours.push_back(std::byte(channel));
  std::vector<std::byte> png;
  for (const int byte : {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a}) png.push_back(std::byte(byte));
  add_chunk(png, "IHDR", header);
  add_chunk(png, "PLTE", colours);
  add_chunk(png, "IDAT", pixels);
  add_chunk(png, "IEND", {});
  return png;
}

}  // namespace fb::tool
