#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "archive/section_reader.h"
#include "archive/section_writer.h"

namespace fb {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

int add_attribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, draco::DataType data, int components,
                  std::uint32_t count) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, false, components * 4, 0);
  return cloud.AddAttribute(attribute, true, count);
}

void add_points(draco::PointCloud& cloud, const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  cloud.set_num_points(count);
  const int id = add_attribute(cloud, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, count);
  for (std::uint32_t v = 0; v < count; ++v)
    cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &mesh.points[std::size_t(3) * v]);
}

std::optional<ByteWriter> encode(draco::ExpertEncoder& encoder, int method, PointOrder order) {
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(0, 0);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return std::nullopt;
  ByteWriter out;
  out.number(static_cast<std::uint32_t>(order));
  out.raw(std::as_bytes(std::span(buffer.data(), buffer.size())));
  return out;
}

// Edgebreaker packs the triangles best but gives vertices back in its own order, so each carries its index.
std::optional<ByteWriter> encode_by_index(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  draco::Mesh out;
  add_points(out, mesh);
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  const int id = add_attribute(out, draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 1, count);
  for (std::uint32_t v = 0; v < count; ++v) out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &v);
  out.SetNumFaces(triangles.size() / 3);
  for (std::uint32_t t = 0; t < triangles.size() / 3; ++t)
    out.SetFace(draco::FaceIndex(t), {draco::PointIndex(triangles[3 * t]), draco::PointIndex(triangles[3 * t + 1]),
                                      draco::PointIndex(triangles[3 * t + 2])});
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::MESH_EDGEBREAKER_ENCODING, PointOrder::by_index);
}

std::optional<ByteWriter> encode_in_order(const Mesh& mesh) {
  draco::PointCloud out;
  add_points(out, mesh);
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, PointOrder::as_stored);
}

// Whether the archive's own reader gets every point back, bit for bit.
bool gives_back(const ByteWriter& section, const Mesh& mesh, std::size_t triangles) {
  try {
    Budget budget(UINT64_MAX);
    ByteReader in(section.bytes, "geometry", budget);
    const auto points = read_geometry(in, static_cast<std::uint32_t>(mesh.vertex_count()), triangles);
    return std::memcmp(points.data(), mesh.points.data(), points.size() * sizeof(float)) == 0;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

ByteWriter write_geometry(const Mesh& mesh) {
  const std::vector<std::uint32_t> triangles = mesh.triangles();
  // Edgebreaker drops isolated vertices and degenerate triangles and splits what is not a manifold: then the plain
  // list.
  if (!triangles.empty())
    if (auto section = encode_by_index(mesh, triangles); section && gives_back(*section, mesh, triangles.size() / 3))
      return std::move(*section);
  auto section = encode_in_order(mesh);
  if (!section || !gives_back(*section, mesh, triangles.size() / 3))
    fail(Status::internal, "Draco does not give the rest mesh's %zu vertices back", mesh.vertex_count());
  return std::move(*section);
}

}  // namespace fb
