#include <algorithm>
#include <string_view>

#include "bake/dataset/rest_mesh.h"
#include "base/file.h"
#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Takes the next word off the front of a line.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
  line.remove_prefix(word.size());
  return word;
}

struct ObjLine {
  const char* file;
  std::size_t number;
  std::string_view rest;

  // `what` needs it, for messages.
  float coordinate(const char* what) {
    const std::string_view word = take_word(rest);
    const auto value = parse_number<float>(word);
    if (!value) fail(Status::bad_data, "%s, line %zu: %s", file, number, what);
    return *value;
  }

  // One of the indices of a corner, counted from one or back from the latest of `count`; what = "vertex".
  std::uint32_t index(std::string_view digits, std::size_t count, const char* what) const {
    const auto parsed = parse_number<long long>(digits);
    if (!parsed)
      fail(Status::bad_data, "%s, line %zu: \"%.*s\" is no corner of a face", file, number,
           static_cast<int>(digits.size()), digits.data());
    const long long index = *parsed, before = static_cast<long long>(count);
    const long long found = index > 0 ? index - 1 : before + index;
    if (index == 0 || found < 0 || found >= before)
      fail(Status::bad_data, "%s, line %zu: %s %lld, but %zu came before", file, number, what, index, count);
    return static_cast<std::uint32_t>(found);
  }

  // Adds "7", "7/1", "7//3" or "7/1/3" to the mesh.
  void corner(std::string_view word, Mesh& mesh) const {
    const auto take_index = [&] {
      const std::string_view digits = word.substr(0, word.find('/'));
      word.remove_prefix(std::min(digits.size() + 1, word.size()));
      return digits;
    };
    mesh.polygon_corners.push_back(index(take_index(), mesh.vertex_count(), "vertex"));
    const std::string_view uv = take_index();
    if (!uv.empty()) mesh.uv_corners.push_back(index(uv, mesh.uvs.size() / 2, "texture coordinate"));
  }
};

}  // namespace

Mesh read_obj(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string name = shown(path);
  Mesh mesh;
  for (std::size_t number = 1; !text.empty(); ++number) {
    ObjLine line{name.c_str(), number, text.substr(0, text.find('\n'))};
    text.remove_prefix(std::min(line.rest.size() + 1, text.size()));
    const std::string_view keyword = take_word(line.rest);
    if (keyword == "v") {
      for (int axis = 0; axis < 3; ++axis) mesh.points.push_back(line.coordinate("a vertex needs three numbers"));
    } else if (keyword == "vt") {
      for (int axis = 0; axis < 2; ++axis)
        mesh.uvs.push_back(line.coordinate("a texture coordinate needs two numbers"));
    } else if (keyword == "f") {
      std::uint32_t size = 0;
      for (std::string_view word; !(word = take_word(line.rest)).empty(); ++size) line.corner(word, mesh);
      if (size < 3) fail(Status::bad_data, "%s, line %zu: a face of %u corners", name.c_str(), number, size);
      mesh.polygon_sizes.push_back(size);
    }
  }
  if (mesh.uv_corners.empty() || mesh.uv_corners.size() != mesh.polygon_corners.size())
    mesh.uvs.clear(), mesh.uv_corners.clear();
  return mesh;
}

}  // namespace fb::bake
