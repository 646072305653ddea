#include "render/palette_png.h"

#include <zlib.h>

#include <cstdint>
#include <span>

#include "base/status.h"
#include "render/palette.h"

namespace fb::tool {
namespace {

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
  const Palette palette = palette_of(image);
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
