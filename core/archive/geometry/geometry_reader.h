// Reads the sections of the rest mesh: "geometry" (positions), "polygons" and "uvs". Input is untrusted: every function
// fails with `corrupt`, `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"
#include "model/mesh.h"

namespace fb::archive {

// How Draco's points map to vertices.
enum class PointOrder : std::uint32_t { as_stored = 0, by_index = 1 };
// How the corners of polygons are coded: as differences, or along the triangles that Draco holds.
enum class CornerCoding : std::uint32_t { deltas = 0, along_triangles = 1 };
// How polygon corners map to texture coordinates.
enum class UvCoding : std::uint32_t { deltas = 0, by_vertex = 1 };
inline constexpr std::int32_t max_grid_coordinate = 0xffffff;  // integers up to here are exact as floats

// The rest points in vertex order, and the triangles that Draco holds of them.
struct RestPoints {
  std::vector<float> points;             // 3 x vertices
  std::vector<std::uint32_t> triangles;  // 3 vertices each; empty with PointOrder::as_stored
};
RestPoints read_geometry(ByteReader& in, std::uint32_t vertices);
// Reads the Draco data, to the end of the section. `grid_step`: what integer positions are multiplied with; 0:
// positions are floats.
RestPoints read_draco(ByteReader& in, PointOrder order, std::uint32_t vertices, std::uint64_t triangles,
                      float grid_step);

// Fills polygon_sizes and polygon_corners. `triangles`: those of RestPoints.
void read_polygons(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles, Mesh& mesh);

// Fills uvs and uv_corners. The polygons have been read.
void read_uvs(ByteReader& in, std::uint32_t vertices, Mesh& mesh);

}  // namespace fb::archive
