#include "render/picture_file.h"

#include <png.h>
#include <turbojpeg.h>
#include <webp/decode.h>

#include <algorithm>
#include <memory>
#include <string_view>

namespace fb::tool {
namespace {

constexpr int most_picture_pixels = 8192;  // along an edge

bool is_drawable(int width, int height) {
  return width > 0 && height > 0 && std::max(width, height) <= most_picture_pixels;
}

Texture empty_texture(int width, int height) {
  Texture texture = {width, height};
  texture.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return texture;
}

std::uint8_t* bytes_of(Texture& texture) {
  return texture.pixels.data()->data();
}

std::optional<Texture> read_png(std::span<const std::byte> file) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, decltype(&png_image_free)> freed(&png, &png_image_free);
  if (!png_image_begin_read_from_memory(&png, file.data(), file.size())) return std::nullopt;
  const int width = static_cast<int>(std::min<png_uint_32>(png.width, most_picture_pixels + 1)),
            height = static_cast<int>(std::min<png_uint_32>(png.height, most_picture_pixels + 1));
  if (!is_drawable(width, height)) return std::nullopt;
  png.format = PNG_FORMAT_RGBA;
  Texture texture = empty_texture(width, height);
  if (!png_image_finish_read(&png, nullptr, bytes_of(texture), 0, nullptr)) return std::nullopt;
  return texture;
}

std::optional<Texture> read_jpeg(std::span<const std::byte> file) {
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), &tjDestroy);
  if (!decoder) return std::nullopt;
  const auto* bytes = reinterpret_cast<const unsigned char*>(file.data());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), bytes, file.size(), &width, &height, &subsampling, &colours) != 0 ||
      !is_drawable(width, height))
    return std::nullopt;
  Texture texture = empty_texture(width, height);
  if (tjDecompress2(decoder.get(), bytes, file.size(), bytes_of(texture), width, 0, height, TJPF_RGBA,
                    TJFLAG_LIMITSCANS | TJFLAG_STOPONWARNING) != 0)
    return std::nullopt;
  return texture;
}

std::optional<Texture> read_webp(std::span<const std::byte> file) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  int width = 0, height = 0;
  if (!WebPGetInfo(bytes, file.size(), &width, &height) || !is_drawable(width, height)) return std::nullopt;
  Texture texture = empty_texture(width, height);
  const std::size_t row = 4 * static_cast<std::size_t>(width);
  if (!WebPDecodeRGBAInto(bytes, file.size(), bytes_of(texture), 4 * texture.pixels.size(), static_cast<int>(row)))
    return std::nullopt;
  return texture;
}

}  // namespace

std::optional<Texture> read_picture_file(std::span<const std::byte> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.starts_with("\x89PNG")) return read_png(file);
  if (text.starts_with("\xff\xd8\xff")) return read_jpeg(file);
  if (text.starts_with("RIFF") && text.size() > 12 && text.substr(8, 4) == "WEBP") return read_webp(file);
  return std::nullopt;
}

}  // namespace fb::tool
