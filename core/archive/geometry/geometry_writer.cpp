#include "archive/geometry/geometry_writer.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "archive/container/byte_reader.h"
#include "archive/geometry/geometry_reader.h"

namespace fb::archive {
namespace {

int add_attribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, draco::DataType data, int components,
                  std::uint32_t count) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, false, components * 4, 0);
  return cloud.AddAttribute(attribute, true, count);
}

// The largest power of two of which all coordinates are multiples within max_grid_coordinate; 0 if there is none.
float find_grid_step(const Mesh& mesh) {
  constexpr int none = 1000;
  int smallest_exponent = none;
  float largest = 0;
  for (const float x : mesh.points) {
    if (x == 0 && std::signbit(x)) return 0;  // integers have no negative zero
    if (x == 0) continue;
    int exponent = 0;
    const auto mantissa = static_cast<std::int32_t>(std::ldexp(std::frexp(x, &exponent), 24));
    smallest_exponent =
        std::min(smallest_exponent, exponent - 24 + std::countr_zero(static_cast<std::uint32_t>(std::abs(mantissa))));
    largest = std::max(largest, std::fabs(x));
  }
  if (smallest_exponent == none) return 0;
  const float step = std::ldexp(1.0f, smallest_exponent);
  return std::isnormal(step) && double(largest) / step <= max_grid_coordinate ? step : 0;
}

void add_points(draco::PointCloud& cloud, const Mesh& mesh, float grid_step) {
  const auto count = static_cast<std::uint32_t>(mesh.surface_vertex_count());
  cloud.set_num_points(count);
  const auto data = grid_step > 0 ? draco::DT_INT32 : draco::DT_FLOAT32;
  const int id = add_attribute(cloud, draco::GeometryAttribute::POSITION, data, 3, count);
  for (std::uint32_t v = 0; v < count; ++v) {
    const float* const point = &mesh.points[std::size_t(3) * v];
    if (grid_step > 0) {
      std::int32_t quantised[3];
      for (int axis = 0; axis < 3; ++axis) quantised[axis] = static_cast<std::int32_t>(point[axis] / grid_step);
      cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), quantised);
    } else {
      cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), point);
    }
  }
}

std::optional<ByteWriter> encode(draco::ExpertEncoder& encoder, int method, PointOrder order, std::size_t triangles,
                                 float grid_step) {
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(0, 0);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return std::nullopt;
  ByteWriter out;
  out.number(static_cast<std::uint32_t>(order));
  out.count(triangles, "triangles");
  out.number(grid_step);
  out.raw(std::as_bytes(std::span(buffer.data(), buffer.size())));
  return out;
}

// Edgebreaker compresses triangles best but reorders vertices, so each point carries the index of its vertex.
std::optional<ByteWriter> encode_mesh(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, float grid_step) {
  draco::Mesh out;
  add_points(out, mesh, grid_step);
  const auto count = static_cast<std::uint32_t>(mesh.surface_vertex_count());
  const int id = add_attribute(out, draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 1, count);
  for (std::uint32_t v = 0; v < count; ++v) out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &v);
  out.SetNumFaces(triangles.size() / 3);
  for (std::uint32_t t = 0; t < triangles.size() / 3; ++t)
    out.SetFace(draco::FaceIndex(t), {draco::PointIndex(triangles[3 * t]), draco::PointIndex(triangles[3 * t + 1]),
                                      draco::PointIndex(triangles[3 * t + 2])});
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::MESH_EDGEBREAKER_ENCODING, PointOrder::by_index, triangles.size() / 3, grid_step);
}

std::optional<ByteWriter> encode_point_cloud(const Mesh& mesh, float grid_step) {
  draco::PointCloud out;
  add_points(out, mesh, grid_step);
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, PointOrder::as_stored, 0, grid_step);
}

// The section and its triangles, if the archive's own reader restores every point bit for bit.
std::optional<WrittenGeometry> if_lossless(std::optional<ByteWriter> section, const Mesh& mesh) {
  if (!section) return std::nullopt;
  try {
    MemoryBudget budget;
    ByteReader in(section->bytes, "geometry", budget);
    RestPoints read = read_geometry(in, static_cast<std::uint32_t>(mesh.surface_vertex_count()));
    if (std::memcmp(read.points.data(), mesh.points.data(), read.points.size() * sizeof(float)) != 0)
      return std::nullopt;
    return WrittenGeometry{std::move(*section), std::move(read.triangles)};
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

WrittenGeometry write_geometry(const Mesh& mesh) {
  const std::vector<std::uint32_t> triangles = mesh.triangles();
  const float grid_step = find_grid_step(mesh);
  // Edgebreaker drops isolated vertices and degenerate triangles and splits vertices that are not manifold. Such meshes
  // are stored as point clouds.
  if (!triangles.empty())
    if (auto written = if_lossless(encode_mesh(mesh, triangles, grid_step), mesh)) return std::move(*written);
  auto written = if_lossless(encode_point_cloud(mesh, grid_step), mesh);
  if (!written)
    fail(Status::internal, "Draco does not restore the rest mesh's %zu vertices", mesh.surface_vertex_count());
  return std::move(*written);
}

}  // namespace fb::archive
