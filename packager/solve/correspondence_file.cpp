#include "solve/correspondence_file.h"

#include <array>
#include <cmath>
#include <facebaker/facebaker_bake.hpp>
#include <unordered_map>
#include <utility>

#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "solve/surface_point_json.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t most_document_bytes = std::uint64_t{256} << 20;
constexpr std::size_t row_numbers = 7;

using Row = std::array<double, row_numbers>;

std::vector<Row> json_rows(const std::filesystem::path& path) {
  const nlohmann::json document = read_json_document(path, most_document_bytes);
  return with_context(shown(path), [&] {
    const auto list = document.is_object() ? document.find("correspondences") : document.end();
    if (list == document.end() || !list->is_array())
      fail(Status::bad_data, "there is no list \"correspondences\" of rows of seven numbers");
    std::vector<Row> rows;
    for (const nlohmann::json& from : *list) {
      bool numbers = from.is_array() && from.size() == row_numbers;
      for (std::size_t k = 0; numbers && k < row_numbers; ++k) numbers = from[k].is_number();
      if (!numbers)
        fail(Status::bad_data, "row %zu is %s: a row is a vertex of the face, three of the target, three weights",
             rows.size(), shown(from.dump()).c_str());
      rows.push_back(from.get<Row>());
    }
    return rows;
  });
}

std::vector<Row> npy_rows(const std::filesystem::path& path) {
  const std::vector<float> values = facebaker::read_clip_file(path.string(), row_numbers);
  std::vector<Row> rows(values.size() / row_numbers);
  for (std::size_t i = 0; i < values.size(); ++i) rows[i / row_numbers][i % row_numbers] = double(values[i]);
  return rows;
}

std::uint32_t index_of(double number, std::size_t count, const char* whose) {
  if (!(number >= 0 && number < static_cast<double>(count)) || number != std::floor(number))
    fail(Status::bad_data, "%g is no vertex of the %s, which has %zu, counted from 0", number, whose, count);
  return static_cast<std::uint32_t>(number);
}

}  // namespace

std::vector<Correspondence> read_correspondence(const std::filesystem::path& path, std::size_t face_vertices,
                                                std::size_t other_vertices) {
  const std::string extension = file_extension(path);
  if (extension != ".json" && extension != ".npy")
    fail(Status::invalid_argument, "%s: correspondences are read from .json and .npy files", shown(path).c_str());
  const std::vector<Row> rows = extension == ".json" ? json_rows(path) : npy_rows(path);
  std::vector<Correspondence> vertices;
  std::unordered_map<std::uint32_t, std::size_t> first;
  for (std::size_t i = 0; i < rows.size(); ++i)
    with_context(format("%s, row %zu", shown(path).c_str(), i), [&] {
      Correspondence c;
      c.vertex = index_of(rows[i][0], face_vertices, "face");
      for (std::size_t k = 0; k < 3; ++k) {
        c.other.vertices[k] = index_of(rows[i][1 + k], other_vertices, "target");
        c.other.weights[k] = checked_weight(rows[i][4 + k]);
      }
      c.other = checked_surface_point(c.other, other_vertices);
      const auto [same, fresh] = first.try_emplace(c.vertex, i);
      if (!fresh) fail(Status::bad_data, "the vertex %u of the face is that of row %zu too", c.vertex, same->second);
      vertices.push_back(c);
    });
  if (vertices.empty()) fail(Status::bad_data, "%s: no correspondences", shown(path).c_str());
  return vertices;
}

void write_correspondence(const std::filesystem::path& path, std::span<const Correspondence> vertices) {
  std::string text = "{\"correspondences\": [";
  const char* before = "\n";
  for (const Correspondence& c : vertices) {
    if (c.partner != Partner::found) continue;
    nlohmann::json row = {c.vertex, c.other.vertices[0], c.other.vertices[1], c.other.vertices[2]};
    for (const auto& weight : weights_json(c.other)) row.push_back(weight);
    text += before + row.dump();
    before = ",\n";
  }
  write_file(path, text + "\n]}\n");
}

}  // namespace fb::tool
