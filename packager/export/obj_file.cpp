#include "export/obj_file.h"

#include <charconv>

#include "base/file.h"

namespace fb::tool {
namespace {

template <class Number>
void append(std::string& text, Number number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  text.append(digits, end);
}

}  // namespace

void write_obj(const std::filesystem::path& path, const std::string& name, const MeshView& mesh,
               std::span<const float> points) {
  std::string text = "o ";
  for (const char c : name) text += c > ' ' ? c : '_';
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += i % 3 == 0 ? "\nv " : " ";
    append(text, points[i]);
  }
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    text += i % 2 == 0 ? "\nvt " : " ";
    append(text, mesh.uvs[i]);
  }
  std::size_t corner = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    text += "\nf";
    for (std::uint32_t k = 0; k < size; ++k, ++corner) {
      text += ' ';
      append(text, std::uint64_t{mesh.polygon_corners[corner]} + 1);
      if (mesh.uvs.empty()) continue;
      text += '/';
      append(text, std::uint64_t{mesh.uv_corners[corner]} + 1);
    }
  }
  text += '\n';
  write_file(path, text);
}

}  // namespace fb::tool
