#include "archive/level_reader.h"

#include "archive/container/container_layout.h"
#include "archive/geometry/corner_coding.h"

namespace fb::archive {
namespace {

void read_level_polygons(ByteReader& in, DetailLevel& level) {
  const auto polygons = in.number<std::uint32_t>("the number of polygons");
  const auto corners = in.number<std::uint32_t>("the number of corners");
  level.polygon_sizes = in.planes(polygons, "polygon sizes");
  std::uint64_t sum = 0;
  for (const std::uint32_t size : level.polygon_sizes) {
    if (size < 3) in.corrupt("a polygon has less than three corners");
    sum += size;
  }
  if (sum != corners) in.corrupt("polygon sizes do not add up to the number of corners");
  level.polygon_corners = in.planes(corners, "corners");
  restore_corners(level.polygon_sizes, level.polygon_corners);
  const auto coding = in.number<std::uint32_t>("the coding of texture coordinates");
  if (coding > static_cast<std::uint32_t>(LevelUvCoding::by_vertex))
    fail(Status::unsupported, "%s has texture coordinates in unknown coding %u", in.where().c_str(), coding);
  if (coding != static_cast<std::uint32_t>(LevelUvCoding::none) && corners == 0)
    in.corrupt("texture coordinates of no corners");
  switch (static_cast<LevelUvCoding>(coding)) {
    case LevelUvCoding::none:
      return;
    case LevelUvCoding::deltas:
      level.uv_corners = in.planes(corners, "texture coordinates");
      restore_corners(level.polygon_sizes, level.uv_corners);
      return;
    case LevelUvCoding::by_vertex:
      in.budget().take(corners, sizeof(std::uint32_t), "texture coordinates");
      level.uv_corners = level.polygon_corners;
      return;
  }
}

void read_level_parts(ByteReader& in, DetailLevel& level) {
  in.budget().resize(level.parts, in.count(8, "meshes"), "meshes");
  for (LevelPart& part : level.parts) {
    part.polygons = in.number<std::uint32_t>("a mesh's polygons");
    in.budget().resize(part.materials, in.count(8, "material runs"), "material runs");
    for (MaterialRun& run : part.materials) {
      run.polygons = in.number<std::uint32_t>("a material run's polygons");
      run.material = in.number<std::uint32_t>("a material run's material");
    }
  }
}

void read_points(ByteReader& in, DetailLevel& level) {
  const std::uint32_t points = in.count(6, "points");
  const auto triangles = in.temporary_planes(points, "triangles of points");
  const auto first = in.temporary_numbers<std::uint8_t>(points, "weights of points");
  const auto second = in.temporary_numbers<std::uint8_t>(points, "weights of points");
  in.budget().resize(level.points, points, "points");
  std::uint32_t triangle = 0;
  for (std::size_t i = 0; i < points; ++i) {
    triangle += from_zigzag(triangles[i]);
    level.points[i] = {triangle, {first[i], second[i]}};
  }
}

void read_used_coefficients(ByteReader& in, DetailLevel& level) {
  const auto coefficients = in.number<std::uint32_t>("the number of coefficients");
  const auto bits = in.take((std::uint64_t(coefficients) + 7) / 8, "used coefficients");
  in.budget().resize(level.used_coefficients, coefficients, "used coefficients");
  for (std::size_t c = 0; c < coefficients; ++c)
    level.used_coefficients[c] = std::to_integer<std::uint8_t>(bits[c / 8]) >> c % 8 & 1;
  if (coefficients % 8 != 0 && std::to_integer<unsigned>(bits.back()) >> coefficients % 8 != 0)
    in.corrupt("coefficients that there are not");
}

}  // namespace

std::vector<DetailLevel> read_levels(ByteReader& in) {
  std::vector<DetailLevel> levels;
  in.budget().resize(levels, in.count(28, "levels"), "levels");
  for (DetailLevel& level : levels) {
    level.vertices = in.number<std::uint32_t>("a level's vertices");
    read_level_polygons(in, level);
    read_level_parts(in, level);
    read_points(in, level);
    read_used_coefficients(in, level);
  }
  if (levels.empty()) in.corrupt("there are no levels");
  in.end();
  return levels;
}

}  // namespace fb::archive
