// The reader of Draco data agrees with Draco's own library on meshes of any topology, and survives damaged data.
#include <doctest/doctest.h>
#include <draco/compression/decode.h>

#include <cmath>

#include "archive/geometry/draco_entropy.h"
#include "archive/geometry/draco_reader.h"
#include "archive/geometry/geometry_writer.h"
#include "base/status.h"
#include "test_models.h"

namespace fb::test_draco_reader {
using namespace archive;
namespace {

// The parts of section "geometry" that matter here.
struct Stored {
  std::uint32_t points = 0, triangles = 0;
  bool integers = false;
  std::vector<std::byte> draco;
};

Stored stored_of(const Mesh& mesh) {
  const std::vector<std::byte> section = write_geometry(mesh).section.bytes;
  MemoryBudget budget;
  ByteReader in(section, "geometry", budget);
  Stored out;
  out.points = in.number<std::uint32_t>("");
  out.triangles = in.number<std::uint32_t>("");
  out.integers = in.number<float>("") > 0;
  in.take(4 * std::uint64_t(out.points), "");
  const auto left = in.take(in.left(), "");
  out.draco.assign(left.begin(), left.end());
  return out;
}

// As Draco decodes it: the bits of positions, then the triangles, points in the order of the positions.
std::vector<std::uint32_t> by_library(const Stored& stored) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stored.draco.data()), stored.draco.size());
  draco::Mesh mesh;
  REQUIRE(draco::Decoder().DecodeBufferToGeometry(&buffer, &mesh).ok());
  CHECK(buffer.remaining_size() == 0);
  const draco::PointAttribute& positions = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::vector<std::uint32_t> out(3 * std::size_t(mesh.num_points()));
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point)
    positions.GetMappedValue(point, &out[3 * std::size_t(positions.mapped_index(point).value())]);
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& point : mesh.face(face)) out.push_back(positions.mapped_index(point).value());
  return out;
}

std::vector<std::uint32_t> by_reader(const Stored& stored) {
  MemoryBudget budget;
  ByteReader in(stored.draco, "geometry", budget);
  const DracoMesh mesh = read_draco(in, stored.points, stored.triangles, stored.integers);
  std::vector<std::uint32_t> out(mesh.positions.begin(), mesh.positions.end());
  out.insert(out.end(), mesh.triangles.begin(), mesh.triangles.end());
  return out;
}

void put_on_grid(Mesh& mesh, float step) {
  for (float& x : mesh.points) x = std::round(x / step) * step + 0.0f;  // no negative zero
}

// Triangles of random vertices.
Mesh random_triangles(Random& random, std::uint32_t vertices, std::uint32_t triangles) {
  Mesh mesh;
  mesh.points = random_values(random, 3 * std::size_t(vertices), 10);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    mesh.polygon_sizes.push_back(3);
    for (int k = 0; k < 3; ++k) mesh.polygon_corners.push_back(random.below(vertices));
  }
  return mesh;
}

}  // namespace

TEST_CASE("Draco's library decodes the same points and triangles") {
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    Mesh mesh = round % 4 == 0 ? odd_surface(5 + random.below(9), 5 + random.below(9), std::uint64_t(round))
                               : random_triangles(random, 4 + random.below(60), 4 + random.below(150));
    if (round % 3 > 0) put_on_grid(mesh, round % 3 == 1 ? 0x1p-12f : 1.0f);
    const Stored stored = stored_of(mesh);
    CHECK_MESSAGE(by_reader(stored) == by_library(stored), round);
  }
}

TEST_CASE("a surface with handles has joins and events") {
  const Stored stored = stored_of(odd_surface(12, 9));
  MemoryBudget budget;
  ByteReader in(stored.draco, "geometry", budget);
  in.take(draco_header_bytes, "");
  CHECK(read_draco_varint(in) == stored.points);
  CHECK(read_draco_varint(in) == stored.triangles);
  in.take(1, "");
  CHECK(read_draco_varint(in) < stored.triangles);  // symbols: some triangles are last faces
  CHECK(read_draco_varint(in) > 0);                 // joins
  CHECK(read_draco_varint(in) > 0);                 // events
}

TEST_CASE("numbers are coded in both ways") {
  for (const bool fine : {true, false}) {
    Mesh mesh = grid_mesh(30, 30);
    put_on_grid(mesh, fine ? 0x1p-16f : 0.25f);
    const Stored stored = stored_of(mesh);
    const std::uint8_t attribute_end[] = {5, 3, 0, 0, 1, 1, 1, 1, std::uint8_t(fine ? 0 : 1)};
    const auto bytes = std::as_bytes(std::span(attribute_end));
    CHECK(std::search(stored.draco.begin(), stored.draco.end(), bytes.begin(), bytes.end()) != stored.draco.end());
    CHECK(by_reader(stored) == by_library(stored));
  }
}

TEST_CASE("damaged data is refused, or is another mesh of as many points and triangles") {
  Random random(3);
  std::size_t refused = 0, accepted = 0;
  for (const float step : {0.0f, 0x1p-10f, 1.0f}) {
    Mesh mesh = odd_surface(7, 6);
    if (step > 0) put_on_grid(mesh, step);
    const Stored whole = stored_of(mesh);
    for (std::size_t at = 0; at < whole.draco.size(); ++at)
      for (int change = 0; change < 4; ++change) {
        Stored damaged = whole;
        damaged.draco[at] = change == 0   ? damaged.draco[at] ^ std::byte(1 << random.below(8))
                            : change == 1 ? std::byte(0xff)
                                          : std::byte(random.below(256));
        if (change == 3) damaged.draco.resize(at);
        try {
          const std::size_t numbers = by_reader(damaged).size();
          CHECK(numbers == 3 * (std::size_t(damaged.points) + damaged.triangles));
          ++accepted;
        } catch (const Error& error) {
          CHECK(error.status() == Status::corrupt);
          ++refused;
        }
      }
  }
  MESSAGE(refused, " refused, ", accepted, " accepted");
  CHECK(refused > 2000);
  CHECK(accepted > 0);
}

TEST_CASE("memory is bounded") {
  const Stored stored = stored_of(odd_surface(30, 30));
  MemoryBudget budget(20000);
  ByteReader in(stored.draco, "geometry", budget);
  try {
    read_draco(in, stored.points, stored.triangles, stored.integers);
    CHECK(false);
  } catch (const Error& error) {
    CHECK(error.status() == Status::limit);
  } catch (const std::bad_alloc&) {
  }
}

}  // namespace fb::test_draco_reader
