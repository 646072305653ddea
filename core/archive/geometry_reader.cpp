#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <exception>

#include "archive/layout.h"
#include "archive/section_reader.h"

namespace fb {
namespace {

// Draco believes the counts it reads and allocates by them. Both decoders below stop it before it allocates, unless the
// counts are those of the definition and the attributes exactly the ones the format has.
struct Expected {
  std::uint32_t vertices = 0;
  std::uint64_t triangles = 0;
};

bool is_position(const draco::PointAttribute& a) {
  return a.attribute_type() == draco::GeometryAttribute::POSITION && a.data_type() == draco::DT_FLOAT32 &&
         a.num_components() == 3;
}

bool is_index(const draco::PointAttribute& a) {
  return a.attribute_type() == draco::GeometryAttribute::GENERIC && a.data_type() == draco::DT_UINT32 &&
         a.num_components() == 1;
}

class GuardedPoints : public draco::PointCloudSequentialDecoder {
 public:
  explicit GuardedPoints(Expected expected) : expected_(expected) {}

 protected:
  bool DecodeGeometryData() override {
    draco::DecoderBuffer peek = *buffer();
    std::int32_t points = 0;
    return peek.Decode(&points) && points >= 0 && std::uint32_t(points) == expected_.vertices &&
           PointCloudSequentialDecoder::DecodeGeometryData();
  }
  bool DecodeAllAttributes() override {
    return point_cloud()->num_attributes() == 1 && is_position(*point_cloud()->attribute(0)) &&
           PointCloudSequentialDecoder::DecodeAllAttributes();
  }

 private:
  Expected expected_;
};

class GuardedMesh : public draco::MeshEdgebreakerDecoder {
 public:
  explicit GuardedMesh(Expected expected) : expected_(expected) {}

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
           is_position(*point_cloud()->attribute(0)) && is_index(*point_cloud()->attribute(1)) &&
           MeshEdgebreakerDecoder::DecodeAllAttributes();
  }

 private:
  Expected expected_;
};

// The bytes begin with Draco's own header: "DRACO", version, geometry, method, flags (0: no metadata).
void check_draco_header(const ByteReader& in, std::span<const std::byte> bytes, std::uint8_t geometry,
                        std::uint8_t method, std::uint8_t minor) {
  const std::uint8_t header[11] = {'D', 'R', 'A', 'C', 'O', 2, minor, geometry, method, 0, 0};
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), header, sizeof header) != 0)
    in.damaged("the Draco data is not of the kind the format allows");
}

// Decodes all bytes, with a decoder above, into a cloud or mesh of as many points as there are vertices.
template <class Decoder, class Points>
void decode(const ByteReader& in, std::span<const std::byte> bytes, Expected expected, Points& points) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Decoder decoder(expected);
  if (!decoder.Decode({}, &buffer, &points).ok() || points.num_points() != expected.vertices)
    in.damaged("the Draco data cannot be decoded");
  if (buffer.remaining_size() != 0) in.damaged("the Draco data should end here");
}

std::vector<float> decode_in_order(const ByteReader& in, std::span<const std::byte> bytes, Expected expected) {
  check_draco_header(in, bytes, draco::POINT_CLOUD, draco::POINT_CLOUD_SEQUENTIAL_ENCODING, 3);
  draco::PointCloud cloud;
  decode<GuardedPoints>(in, bytes, expected, cloud);
  std::vector<float> points(std::size_t(3) * expected.vertices);
  for (std::uint32_t v = 0; v < expected.vertices; ++v)
    cloud.attribute(0)->GetMappedValue(draco::PointIndex(v), &points[std::size_t(3) * v]);
  return points;
}

std::vector<float> decode_by_index(const ByteReader& in, std::span<const std::byte> bytes, Expected expected) {
  check_draco_header(in, bytes, draco::TRIANGULAR_MESH, draco::MESH_EDGEBREAKER_ENCODING, 2);
  draco::Mesh mesh;
  decode<GuardedMesh>(in, bytes, expected, mesh);
  std::vector<float> points(std::size_t(3) * expected.vertices);
  std::vector<bool> given(expected.vertices);
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    std::uint32_t vertex = 0;
    mesh.attribute(1)->GetMappedValue(point, &vertex);
    if (vertex >= expected.vertices || given[vertex]) in.damaged("the Draco mesh does not give every vertex once");
    given[vertex] = true;
    mesh.attribute(0)->GetMappedValue(point, &points[std::size_t(3) * vertex]);
  }
  return points;
}

}  // namespace

std::vector<float> read_geometry(ByteReader& in, std::uint32_t vertices, std::uint64_t triangles) {
  const auto order = in.number<std::uint32_t>("the order of points");
  const auto bytes = in.take(in.left(), "Draco data");
  if (bytes.size() / 12 < vertices) in.damaged("the Draco data is too short for the points of all vertices");
  // About what Draco holds a vertex and a triangle while it decodes, beside the points themselves.
  in.budget().take(vertices, 64, "rest points");
  in.budget().take(triangles, 64, "rest triangles");
  try {
    switch (static_cast<PointOrder>(order)) {
      case PointOrder::as_stored:
        return decode_in_order(in, bytes, {vertices, triangles});
      case PointOrder::by_index:
        return decode_by_index(in, bytes, {vertices, triangles});
    }
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    in.damaged(error.what());
  }
  fail(Status::unsupported, "%s has points in unknown order %u", in.where().c_str(), order);
}

}  // namespace fb
