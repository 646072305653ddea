#include "solve/surface_point_json.h"

#include <cmath>
#include <string>

#include "base/file.h"
#include "base/json_depth.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {

nlohmann::json read_json_document(const std::filesystem::path& path, std::uint64_t most_bytes) {
  const std::vector<std::byte> bytes = read_file(path, most_bytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return with_context(shown(path), [&] {
    check_json_depth(text);
    try {
      return nlohmann::json::parse(text);
    } catch (const nlohmann::json::exception& error) {  // also of numbers that no double holds
      fail(Status::bad_data, "no JSON: %s", shown(error.what()).c_str());
    }
  });
}

SurfacePoint surface_point_of(const nlohmann::json& vertices, const nlohmann::json& weights, std::size_t vertex_count) {
  if (!vertices.is_array() || vertices.empty() || vertices.size() > 3)
    fail(Status::bad_data, "\"vertices\" is no list of one to three vertices");
  SurfacePoint point;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    if (!vertices[k].is_number_unsigned() || vertices[k].get<std::uint64_t>() > UINT32_MAX)
      fail(Status::bad_data, "\"vertices\" has %s, no number of a vertex", shown(vertices[k].dump()).c_str());
    point.vertices[k] = vertices[k].get<std::uint32_t>();
  }
  for (std::size_t k = vertices.size(); k < 3; ++k) point.vertices[k] = point.vertices[0];
  if (vertices.size() == 1 && weights.is_null()) {
    point.weights = {1, 0, 0};
    return checked_surface_point(point, vertex_count);
  }
  if (!weights.is_array() || weights.size() != vertices.size())
    fail(Status::bad_data, "\"weights\" is no list of a number for each of the %zu vertices", vertices.size());
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (!weights[k].is_number())
      fail(Status::bad_data, "\"weights\" has %s, no number", shown(weights[k].dump()).c_str());
    point.weights[k] = checked_weight(weights[k].get<double>());
  }
  return checked_surface_point(point, vertex_count);
}

float checked_weight(double weight) {
  if (!(weight >= -1 && weight <= 2)) fail(Status::bad_data, "the weight %g is not from -1 to 2", weight);
  return static_cast<float>(weight);
}

SurfacePoint checked_surface_point(SurfacePoint point, std::size_t vertex_count) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.vertices[k] >= vertex_count)
      fail(Status::bad_data, "vertex %u, while there are %zu, counted from 0", point.vertices[k], vertex_count);
    sum += double(point.weights[k]);
  }
  if (!(std::abs(sum - 1) <= 1e-3)) fail(Status::bad_data, "the weights sum to %g, not to 1", sum);
  for (float& weight : point.weights) weight = static_cast<float>(weight / sum);
  return point;
}

nlohmann::json weights_json(const SurfacePoint& point) {
  const auto rounded = [](double value) { return std::round(value * 1e6) / 1e6; };
  const double a = rounded(double(point.weights[0])), b = rounded(double(point.weights[1]));
  return {a, b, rounded(1 - a - b)};
}

}  // namespace fb::tool
