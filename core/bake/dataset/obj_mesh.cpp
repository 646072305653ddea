#include <charconv>
#include <string_view>

#include "bake/dataset/rest_mesh.h"
#include "base/file.h"
#include "base/status.h"

namespace fb {
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

  float coordinate() {
    const std::string_view word = take_word(rest);
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      fail(Status::bad_data, "%s, line %zu: a vertex needs three numbers", file, number);
    return value;
  }

  // "7", "7/1", "7//3", "-1": the vertex counted from one, or back from the latest.
  std::uint32_t corner(std::string_view word, std::size_t vertices) const {
    long long index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error != std::errc() || (end != word.data() + word.size() && *end != '/'))
      fail(Status::bad_data, "%s, line %zu: \"%.*s\" is no corner of a face", file, number,
           static_cast<int>(word.size()), word.data());
    const auto count = static_cast<long long>(vertices);
    const long long vertex = index > 0 ? index - 1 : count + index;
    if (index == 0 || vertex < 0 || vertex >= count)
      fail(Status::bad_data, "%s, line %zu: vertex %lld, but %zu came before", file, number, index, vertices);
    return static_cast<std::uint32_t>(vertex);
  }
};

}  // namespace

Mesh read_obj(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Mesh mesh;
  for (std::size_t number = 1; !text.empty(); ++number) {
    ObjLine line{path.c_str(), number, text.substr(0, text.find('\n'))};
    text.remove_prefix(std::min(line.rest.size() + 1, text.size()));
    const std::string_view keyword = take_word(line.rest);
    if (keyword == "v") {
      for (int axis = 0; axis < 3; ++axis) mesh.points.push_back(line.coordinate());
    } else if (keyword == "f") {
      std::uint32_t size = 0;
      for (std::string_view word; !(word = take_word(line.rest)).empty(); ++size)
        mesh.polygon_corners.push_back(line.corner(word, mesh.vertex_count()));
      if (size < 3) fail(Status::bad_data, "%s, line %zu: a face of %u corners", path.c_str(), number, size);
      mesh.polygon_sizes.push_back(size);
    }
  }
  return mesh;
}

}  // namespace fb
