#include "bake/rig/gltf/gltf_image.h"

#include <tiny_gltf.h>

#include <cstring>
#include <span>
#include <string_view>

#include "base/status.h"

namespace fb::bake {
namespace {

// What a picture file begins with: PNG and JPEG as in glTF 2.0, section 3.8.3; KTX2 and WebP as their own
// specifications say.
std::string media_type_of(std::span<const std::byte> bytes) {
  using namespace std::string_view_literals;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x89PNG\r\n\x1a\n"sv)) return "image/png";
  if (text.starts_with("\xff\xd8\xff"sv)) return "image/jpeg";
  if (text.starts_with("\xabKTX 20\xbb\r\n\x1a\n"sv)) return "image/ktx2";
  if (text.starts_with("RIFF"sv) && text.size() >= 12 && text.substr(8, 4) == "WEBP"sv) return "image/webp";
  return "";
}

// Of a file beside; nothing of a data URI.
std::string name_from_uri(const std::string& uri) {
  return uri.starts_with("data:") ? "" : uri.substr(uri.rfind('/') + 1);
}

}  // namespace

Image read_gltf_image(const GltfFile& file, std::size_t index) {
  const auto& images = file.model().images;
  if (index >= images.size()) fail(Status::bad_data, "a texture names image %zu of %zu", index, images.size());
  const tinygltf::Image& from = images[index];
  return with_context(format("image %zu (\"%s\")", index, from.name.c_str()), [&] {
    Image image;
    image.name = from.name.empty() ? name_from_uri(from.uri) : from.name;
    if (from.bufferView >= 0) {
      const std::span<const std::byte> bytes = file.view(from.bufferView, "bytes");
      image.bytes.assign(bytes.begin(), bytes.end());
    } else if (!from.image.empty()) {  // a data URI that the loader has decoded
      const auto bytes = std::as_bytes(std::span(from.image));
      image.bytes.assign(bytes.begin(), bytes.end());
    } else {
      image.bytes = file.read_uri(from.uri);
    }
    image.media_type = media_type_of(image.bytes);
    return image;
  });
}

}  // namespace fb::bake
