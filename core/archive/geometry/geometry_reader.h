// Reads the sections of the rest mesh: "geometry" (positions), "polygons" and "uvs". Input is untrusted: every function
// fails with `corrupt`, `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"
#include "model/mesh.h"

namespace fb::archive {

// The edge index of a polygon whose corners are coded as differences.
inline constexpr std::uint8_t no_edge = 255;
// How polygon corners map to texture coordinates.
enum class UvCoding : std::uint32_t { deltas = 0, by_vertex = 1 };

// The rest points in vertex order, and the triangles along which polygons may be coded: those of the mesh as far as
// they have three different corners, in any order, and some of no meaning.
struct RestPoints {
  std::vector<float> points;             // 3 x vertices
  std::vector<std::uint32_t> triangles;  // 3 vertices each
};
RestPoints read_geometry(ByteReader& in, std::uint32_t vertices);

// Fills polygon_sizes and polygon_corners. `triangles`: those of RestPoints.
void read_polygons(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles, Mesh& mesh);

// Fills uvs and uv_corners. The polygons have been read.
void read_uvs(ByteReader& in, std::uint32_t vertices, Mesh& mesh);

}  // namespace fb::archive
