#include "archive/level_writer.h"

#include "archive/geometry/corner_coding.h"
#include "archive/level_reader.h"

namespace fb::archive {
namespace {

void write_level_polygons(ByteWriter& out, const DetailLevel& level) {
  out.count(level.polygon_sizes.size(), "polygons");
  out.count(level.polygon_corners.size(), "polygon corners");
  out.planes(level.polygon_sizes);
  out.planes(corner_deltas(level.polygon_sizes, level.polygon_corners));
  const LevelUvCoding coding = level.uv_corners.empty()                    ? LevelUvCoding::none
                               : level.uv_corners == level.polygon_corners ? LevelUvCoding::by_vertex
                                                                           : LevelUvCoding::deltas;
  out.number(static_cast<std::uint32_t>(coding));
  if (coding == LevelUvCoding::deltas) out.planes(corner_deltas(level.polygon_sizes, level.uv_corners));
}

void write_level_parts(ByteWriter& out, const DetailLevel& level) {
  out.count(level.parts.size(), "meshes");
  for (const LevelPart& part : level.parts) {
    out.number(part.polygons);
    out.count(part.materials.size(), "material runs");
    for (const MaterialRun& run : part.materials) {
      out.number(run.polygons);
      out.number(run.material);
    }
  }
}

void write_points(ByteWriter& out, const DetailLevel& level) {
  out.count(level.points.size(), "points");
  std::vector<std::uint32_t> deltas;
  std::uint32_t before = 0;
  for (const SurfacePoint& point : level.points) {
    deltas.push_back(to_zigzag(point.triangle - before));
    before = point.triangle;
  }
  out.planes(deltas);
  for (const std::size_t weight : {0, 1})
    for (const SurfacePoint& point : level.points) out.number(point.weights[weight]);
}

void write_used_coefficients(ByteWriter& out, const DetailLevel& level) {
  out.count(level.used_coefficients.size(), "coefficients");
  std::vector<std::uint8_t> bits((level.used_coefficients.size() + 7) / 8);
  for (std::size_t c = 0; c < level.used_coefficients.size(); ++c)
    if (level.used_coefficients[c]) bits[c / 8] |= static_cast<std::uint8_t>(1u << c % 8);
  out.numbers(bits);
}

}  // namespace

ByteWriter write_levels(const PackedModel& model) {
  ByteWriter out;
  out.count(model.levels.size(), "levels");
  for (const DetailLevel& level : model.levels) {
    out.number(level.vertices);
    write_level_polygons(out, level);
    write_level_parts(out, level);
    write_points(out, level);
    write_used_coefficients(out, level);
  }
  return out;
}

}  // namespace fb::archive
