#include "archive/geometry/geometry_writer.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "archive/container/byte_reader.h"
#include "archive/container/container_layout.h"
#include "archive/geometry/draco_entropy.h"
#include "archive/geometry/draco_reader.h"
#include "archive/geometry/geometry_reader.h"

namespace fb::archive {
namespace {

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

// What Draco gets: points, each of a vertex, and triangles of three different points. Draco leaves out points that are
// of no triangle, so that vertices without one get triangles that mean nothing, of points of their own.
struct DracoInput {
  std::vector<std::uint32_t> vertex_of;
  std::vector<draco::Mesh::Face> triangles;
};

DracoInput input_of(const Mesh& mesh) {
  const auto vertices = static_cast<std::uint32_t>(mesh.surface_vertex_count());
  DracoInput out;
  out.vertex_of.resize(vertices);
  std::iota(out.vertex_of.begin(), out.vertex_of.end(), 0u);
  std::vector<bool> is_used(vertices, false);
  const std::vector<std::uint32_t> corners = mesh.triangles();
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const std::uint32_t a = corners[t], b = corners[t + 1], c = corners[t + 2];
    if (a == b || b == c || c == a) continue;
    is_used[a] = is_used[b] = is_used[c] = true;
    out.triangles.push_back({draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
  }
  std::vector<std::uint32_t> loose;
  for (std::uint32_t v = 0; v < vertices; ++v)
    if (!is_used[v]) loose.push_back(v);
  while (loose.size() % 3 != 0) {
    const std::uint32_t vertex = out.vertex_of[loose.back()];
    loose.push_back(static_cast<std::uint32_t>(out.vertex_of.size()));
    out.vertex_of.push_back(vertex);
  }
  for (std::size_t i = 0; i < loose.size(); i += 3)
    out.triangles.push_back(
        {draco::PointIndex(loose[i]), draco::PointIndex(loose[i + 1]), draco::PointIndex(loose[i + 2])});
  return out;
}

// Encodes a mesh with these positions, three numbers a point: the bits of integers, or of floats.
std::vector<std::byte> encode_draco(const std::vector<std::uint32_t>& positions, bool integers,
                                    const std::vector<draco::Mesh::Face>& triangles) {
  draco::Mesh mesh;
  const auto count = static_cast<std::uint32_t>(positions.size() / 3);
  mesh.set_num_points(count);
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, integers ? draco::DT_INT32 : draco::DT_FLOAT32, false,
                 12, 0);
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t p = 0; p < count; ++p)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(p), &positions[std::size_t(3) * p]);
  mesh.SetNumFaces(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) mesh.SetFace(draco::FaceIndex(t), triangles[t]);
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(1, 1);  // 0 would visit vertices in another order
  encoder.options().SetGlobalBool("split_mesh_on_seams", true);
  encoder.options().SetGlobalInt("edgebreaker_method", draco::MESH_EDGEBREAKER_STANDARD_ENCODING);
  encoder.options().SetAttributeInt(id, "prediction_scheme", draco::MESH_PREDICTION_PARALLELOGRAM);
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
    fail(Status::internal, "Draco cannot encode the rest mesh: %s", status.error_msg());
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

// For each point of the decoded mesh, the point that was encoded. Draco orders points anew, and splits those where the
// surface touches itself, by the triangles alone: so points are found by positions that are their numbers.
std::vector<std::uint32_t> order_of_points(const DracoInput& input) {
  constexpr std::uint32_t bits = 20;  // of a number in x, the others in y
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t p = 0; p < input.vertex_of.size(); ++p)
    for (const std::uint32_t word : {p % (1u << bits), p >> bits, 0u}) numbers.push_back(word);
  const std::vector<std::byte> bytes = encode_draco(numbers, true, input.triangles);
  MemoryBudget budget;
  ByteReader in(bytes, "Draco data", budget);
  ByteReader counts = in;
  counts.take(draco_header_bytes, "the header");
  const std::uint32_t points = read_draco_varint(counts);
  const DracoMesh mesh = read_draco(in, points, static_cast<std::uint32_t>(input.triangles.size()), true);
  std::vector<std::uint32_t> order;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3)
    order.push_back(mesh.positions[i] + (mesh.positions[i + 1] << bits));
  return order;
}

// The bits of the points' positions.
std::vector<std::uint32_t> position_bits(const Mesh& mesh, const DracoInput& input, float grid_step) {
  std::vector<std::uint32_t> bits;
  for (const std::uint32_t vertex : input.vertex_of)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = mesh.points[std::size_t(3) * vertex + axis];
      bits.push_back(grid_step == 0 ? std::bit_cast<std::uint32_t>(x)
                                    : static_cast<std::uint32_t>(static_cast<std::int32_t>(x / grid_step)));
    }
  return bits;
}

// What the archive's own reader makes of a section.
RestPoints read_again(const ByteWriter& section, const Mesh& mesh) {
  MemoryBudget budget;
  ByteReader in(section.bytes, "geometry", budget);
  RestPoints read = read_geometry(in, static_cast<std::uint32_t>(mesh.surface_vertex_count()));
  if (std::memcmp(read.points.data(), mesh.points.data(), read.points.size() * sizeof(float)) != 0)
    fail(Status::internal, "Draco does not restore the rest mesh's %zu vertices", mesh.surface_vertex_count());
  return read;
}

}  // namespace

WrittenGeometry write_geometry(const Mesh& mesh) {
  const float grid_step = find_grid_step(mesh);
  const DracoInput input = input_of(mesh);
  std::vector<std::uint32_t> deltas;
  std::uint32_t before = 0;
  for (const std::uint32_t point : order_of_points(input)) {
    const std::uint32_t vertex = input.vertex_of[point];
    deltas.push_back(to_zigzag(vertex - std::exchange(before, vertex)));
  }
  WrittenGeometry out;
  out.section.count(deltas.size(), "points");
  out.section.count(input.triangles.size(), "triangles");
  out.section.number(grid_step);
  out.section.planes(deltas);
  out.section.raw(encode_draco(position_bits(mesh, input, grid_step), grid_step > 0, input.triangles));
  out.triangles = read_again(out.section, mesh).triangles;
  return out;
}

}  // namespace fb::archive
