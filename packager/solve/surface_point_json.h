#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "solve/surface_point.h"

namespace fb::tool {

// A JSON document from anyone. Fails with bad_data where it is none, naming the file.
nlohmann::json read_json_document(const std::filesystem::path& path, std::uint64_t most_bytes);

// One to three vertices of a mesh of vertex_count with their weights, which one vertex needs none of. Fails with
// bad_data on anything else.
SurfacePoint surface_point_of(const nlohmann::json& vertices, const nlohmann::json& weights, std::size_t vertex_count);

// Fails with bad_data unless it is from -1 to 2.
float checked_weight(double weight);

// With weights that sum to 1. Fails with bad_data unless vertices are less than vertex_count, and weights sum to 1
// within 0.001.
SurfacePoint checked_surface_point(SurfacePoint point, std::size_t vertex_count);

// With six decimals, whose sum is 1.
nlohmann::json weights_json(const SurfacePoint& point);

}  // namespace fb::tool
