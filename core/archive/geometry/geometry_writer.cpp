#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "archive/container/layout.h"
#include "archive/section_reader.h"
#include "archive/section_writer.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

int add_attribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, draco::DataType data, int components,
                  std::uint32_t count) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, false, components * 4, 0);
  return cloud.AddAttribute(attribute, true, count);
}

// The largest power of two of which all coordinates are multiples that a grid may hold; 0 if there is none.
float grid_step(const Mesh& mesh) {
  constexpr int none = 1000;
  int finest = none;
  float most = 0;
  for (const float x : mesh.points) {
    if (x == 0 && std::signbit(x)) return 0;
    if (x == 0) continue;
    int exponent = 0;
    const auto digits = static_cast<std::int32_t>(std::ldexp(std::frexp(x, &exponent), 24));
    finest = std::min(finest, exponent - 24 + std::countr_zero(static_cast<std::uint32_t>(std::abs(digits))));
    most = std::max(most, std::fabs(x));
  }
  if (finest == none) return 0;
  const float step = std::ldexp(1.0f, finest);
  return std::isnormal(step) && double(most) / step <= most_steps ? step : 0;
}

void add_points(draco::PointCloud& cloud, const Mesh& mesh, float step) {
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  cloud.set_num_points(count);
  const auto data = step > 0 ? draco::DT_INT32 : draco::DT_FLOAT32;
  const int id = add_attribute(cloud, draco::GeometryAttribute::POSITION, data, 3, count);
  for (std::uint32_t v = 0; v < count; ++v) {
    const float* const point = &mesh.points[std::size_t(3) * v];
    if (step > 0) {
      std::int32_t numbers[3];
      for (int axis = 0; axis < 3; ++axis) numbers[axis] = static_cast<std::int32_t>(point[axis] / step);
      cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), numbers);
    } else {
      cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), point);
    }
  }
}

std::optional<ByteWriter> encode(draco::ExpertEncoder& encoder, int method, PointOrder order, std::size_t triangles,
                                 float step) {
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(0, 0);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return std::nullopt;
  ByteWriter out;
  out.number(static_cast<std::uint32_t>(order));
  out.number(checked_u32(triangles, "triangles"));
  out.number(step);
  out.raw(std::as_bytes(std::span(buffer.data(), buffer.size())));
  return out;
}

// Edgebreaker packs the triangles best but gives vertices back in its own order, so each carries its index.
std::optional<ByteWriter> encode_by_index(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, float step) {
  draco::Mesh out;
  add_points(out, mesh, step);
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  const int id = add_attribute(out, draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 1, count);
  for (std::uint32_t v = 0; v < count; ++v) out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &v);
  out.SetNumFaces(triangles.size() / 3);
  for (std::uint32_t t = 0; t < triangles.size() / 3; ++t)
    out.SetFace(draco::FaceIndex(t), {draco::PointIndex(triangles[3 * t]), draco::PointIndex(triangles[3 * t + 1]),
                                      draco::PointIndex(triangles[3 * t + 2])});
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::MESH_EDGEBREAKER_ENCODING, PointOrder::by_index, triangles.size() / 3, step);
}

std::optional<ByteWriter> encode_in_order(const Mesh& mesh, float step) {
  draco::PointCloud out;
  add_points(out, mesh, step);
  draco::ExpertEncoder encoder(out);
  return encode(encoder, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, PointOrder::as_stored, 0, step);
}

// The section and its triangles, if the archive's own reader gets every point back, bit for bit.
std::optional<WrittenGeometry> given_back(std::optional<ByteWriter> section, const Mesh& mesh) {
  if (!section) return std::nullopt;
  try {
    Budget budget(UINT64_MAX);
    ByteReader in(section->bytes, "geometry", budget);
    RestPoints read = read_geometry(in, static_cast<std::uint32_t>(mesh.vertex_count()));
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
  const float step = grid_step(mesh);
  // Edgebreaker drops isolated vertices and degenerate triangles and splits what is not a manifold: then the plain
  // list.
  if (!triangles.empty())
    if (auto written = given_back(encode_by_index(mesh, triangles, step), mesh)) return std::move(*written);
  auto written = given_back(encode_in_order(mesh, step), mesh);
  if (!written) fail(Status::internal, "Draco does not give the rest mesh's %zu vertices back", mesh.vertex_count());
  return std::move(*written);
}

}  // namespace fb::archive
