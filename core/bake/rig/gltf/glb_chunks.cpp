#include "bake/rig/gltf/glb_chunks.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "base/checked.h"

namespace fb::bake {
namespace {

// glTF 2.0, section 4.4: "glTF", version and length of the file; length and type of the first chunk; the chunk.
constexpr std::size_t file_length_at = 8, chunk_length_at = 12, chunk_at = 20;

void put_number(std::vector<std::byte>& bytes, std::size_t at, std::size_t number) {
  const std::uint32_t value = checked_u32(number, "bytes");
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

std::string_view json_of_gltf(std::span<const std::byte> bytes, bool binary) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!binary) return text;
  std::uint32_t length = 0;
  if (bytes.size() >= chunk_at) std::memcpy(&length, bytes.data() + chunk_length_at, sizeof length);
  return text.substr(std::min(chunk_at, text.size()), length);
}

std::vector<std::byte> with_json(std::span<const std::byte> bytes, bool binary, std::string json) {
  if (binary) json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto text = std::as_bytes(std::span(json));
  if (!binary) return {text.begin(), text.end()};
  const std::span<const std::byte> behind =
      bytes.subspan(std::min(bytes.size(), chunk_at + json_of_gltf(bytes, true).size()));
  std::vector<std::byte> made(bytes.begin(),
                              bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), chunk_at)));
  made.insert(made.end(), text.begin(), text.end());
  made.insert(made.end(), behind.begin(), behind.end());
  put_number(made, file_length_at, made.size());
  put_number(made, chunk_length_at, text.size());
  return made;
}

}  // namespace fb::bake
