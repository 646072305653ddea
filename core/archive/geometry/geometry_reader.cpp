#include "archive/geometry/geometry_reader.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <cmath>
#include <cstring>
#include <exception>

namespace fb::archive {
namespace {

// What Draco allocates at most while it decodes, beside the result; the test load_memory fails if it is more.
constexpr std::size_t draco_bytes_per_vertex = 96, draco_bytes_per_triangle = 96;

// Draco allocates by the counts in its data without checking them. The two decoders below fail before it allocates,
// unless the counts are those of the archive and the attributes those of the format.
struct Expected {
  std::uint32_t vertices = 0;
  std::uint64_t triangles = 0;
  float grid_step = 0;  // of integer positions; 0: positions are floats
};

bool is_position(const draco::PointAttribute& a, const Expected& expected) {
  return a.attribute_type() == draco::GeometryAttribute::POSITION && a.num_components() == 3 &&
         a.data_type() == (expected.grid_step > 0 ? draco::DT_INT32 : draco::DT_FLOAT32);
}

bool is_index(const draco::PointAttribute& a) {
  return a.attribute_type() == draco::GeometryAttribute::GENERIC && a.data_type() == draco::DT_UINT32 &&
         a.num_components() == 1;
}

class CheckedPointDecoder : public draco::PointCloudSequentialDecoder {
 public:
  explicit CheckedPointDecoder(Expected expected) : expected_(expected) {}

 protected:
  bool DecodeGeometryData() override {
    draco::DecoderBuffer peek = *buffer();
    std::int32_t points = 0;
    return peek.Decode(&points) && points >= 0 && std::uint32_t(points) == expected_.vertices &&
           PointCloudSequentialDecoder::DecodeGeometryData();
  }
  bool DecodeAllAttributes() override {
    return point_cloud()->num_attributes() == 1 && is_position(*point_cloud()->attribute(0), expected_) &&
           PointCloudSequentialDecoder::DecodeAllAttributes();
  }

 private:
  Expected expected_;
};

class CheckedMeshDecoder : public draco::MeshEdgebreakerDecoder {
 public:
  explicit CheckedMeshDecoder(Expected expected) : expected_(expected) {}

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer peek = *buffer();
    std::uint32_t vertices = 0, faces = 0, symbols = 0, splits = 0;
    std::uint8_t attribute_data = 0;
    return draco::DecodeVarint(&vertices, &peek) && draco::DecodeVarint(&faces, &peek) &&
           peek.Decode(&attribute_data) && draco::DecodeVarint(&symbols, &peek) &&
           draco::DecodeVarint(&splits, &peek) && vertices <= expected_.vertices && faces == expected_.triangles &&
           attribute_data <= 2 && splits <= faces && MeshEdgebreakerDecoder::DecodeConnectivity();
  }
  bool DecodeAllAttributes() override {
    return point_cloud()->num_points() == expected_.vertices && point_cloud()->num_attributes() == 2 &&
           is_position(*point_cloud()->attribute(0), expected_) && is_index(*point_cloud()->attribute(1)) &&
           MeshEdgebreakerDecoder::DecodeAllAttributes();
  }

 private:
  Expected expected_;
};

// Draco's own header: "DRACO", version, geometry type, encoding method, flags (0: no metadata).
void check_draco_header(const ByteReader& in, std::span<const std::byte> bytes, std::uint8_t geometry,
                        std::uint8_t method, std::uint8_t minor) {
  const std::uint8_t header[11] = {'D', 'R', 'A', 'C', 'O', 2, minor, geometry, method, 0, 0};
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), header, sizeof header) != 0)
    in.corrupt("the Draco data is not of the type the format allows");
}

// Decodes all bytes with one of the decoders above into a point cloud or mesh with one point per vertex.
template <class Decoder, class Points>
void decode(const ByteReader& in, std::span<const std::byte> bytes, Expected expected, Points& points) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Decoder decoder(expected);
  if (!decoder.Decode({}, &buffer, &points).ok() || points.num_points() != expected.vertices)
    in.corrupt("the Draco data cannot be decoded");
  if (buffer.remaining_size() != 0) in.corrupt("the Draco data should end here");
}

// Writes the x, y and z of a point to `to`.
void read_position(const ByteReader& in, const draco::PointAttribute& positions, draco::PointIndex point,
                   float grid_step, float* to) {
  if (grid_step == 0) return positions.GetMappedValue(point, to);
  std::int32_t quantised[3];
  positions.GetMappedValue(point, quantised);
  for (int axis = 0; axis < 3; ++axis) {
    if (quantised[axis] < -max_grid_coordinate || quantised[axis] > max_grid_coordinate)
      in.corrupt("a position is beyond its grid");
    to[axis] = static_cast<float>(quantised[axis]) * grid_step;
  }
}

RestPoints decode_point_cloud(ByteReader& in, std::span<const std::byte> bytes, Expected expected) {
  check_draco_header(in, bytes, draco::POINT_CLOUD, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, 3);
  if (expected.triangles != 0) in.corrupt("a point cloud has triangles");
  draco::PointCloud cloud;
  decode<CheckedPointDecoder>(in, bytes, expected, cloud);
  RestPoints out;
  in.budget().resize(out.points, std::uint64_t(3) * expected.vertices, "rest points");
  for (std::uint32_t v = 0; v < expected.vertices; ++v)
    read_position(in, *cloud.attribute(0), draco::PointIndex(v), expected.grid_step, &out.points[std::size_t(3) * v]);
  return out;
}

RestPoints decode_mesh(ByteReader& in, std::span<const std::byte> bytes, Expected expected) {
  check_draco_header(in, bytes, draco::TRIANGULAR_MESH, draco::MESH_EDGEBREAKER_ENCODING, 2);
  draco::Mesh mesh;
  decode<CheckedMeshDecoder>(in, bytes, expected, mesh);
  RestPoints out;
  in.budget().resize(out.points, std::uint64_t(3) * expected.vertices, "rest points");
  std::pmr::vector<std::uint32_t> vertex_of(expected.vertices, &in.budget());
  std::pmr::vector<bool> present(expected.vertices, false, &in.budget());
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    std::uint32_t& vertex = vertex_of[point.value()];
    mesh.attribute(1)->GetMappedValue(point, &vertex);
    if (vertex >= expected.vertices || present[vertex]) in.corrupt("the Draco mesh does not hold every vertex once");
    present[vertex] = true;
    read_position(in, *mesh.attribute(0), point, expected.grid_step, &out.points[std::size_t(3) * vertex]);
  }
  in.budget().reserve(out.triangles, 3 * expected.triangles, "rest triangles");
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& point : mesh.face(face)) out.triangles.push_back(vertex_of[point.value()]);
  return out;
}

}  // namespace

RestPoints read_geometry(ByteReader& in, std::uint32_t vertices) {
  const auto order = in.number<std::uint32_t>("the order of points");
  const auto triangles = in.number<std::uint32_t>("the number of triangles");
  const auto grid_step = in.number<float>("the grid step");
  int exponent = 0;
  if (grid_step != 0 && !(std::isfinite(grid_step) && grid_step > 0 && std::frexp(grid_step, &exponent) == 0.5f))
    in.corrupt("the grid step is no power of two");
  return read_draco(in, static_cast<PointOrder>(order), vertices, triangles, grid_step);
}

RestPoints read_draco(ByteReader& in, PointOrder order, std::uint32_t vertices, std::uint64_t triangles,
                      float grid_step) {
  const auto bytes = in.take(in.left(), "Draco data");
  if (grid_step == 0 && bytes.size() / 12 < vertices)
    in.corrupt("the Draco data is too short for the points of all vertices");
  const ScopedCharge of_points(in.budget(), vertices, draco_bytes_per_vertex, "rest points");
  const ScopedCharge of_triangles(in.budget(), triangles, draco_bytes_per_triangle, "rest triangles");
  try {
    switch (order) {
      case PointOrder::as_stored:
        return decode_point_cloud(in, bytes, {vertices, triangles, grid_step});
      case PointOrder::by_index:
        return decode_mesh(in, bytes, {vertices, triangles, grid_step});
    }
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    in.corrupt(error.what());
  }
  fail(Status::unsupported, "%s has points in unknown order %u", in.where().c_str(), static_cast<unsigned>(order));
}

}  // namespace fb::archive
