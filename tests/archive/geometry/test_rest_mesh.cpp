// Rest meshes are restored exactly, whatever their topology: vertices and polygons in order, first corners, every bit.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "archive/geometry/geometry_reader.h"
#include "archive/reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/status.h"
#include "test_models.h"

namespace fb::test_rest_mesh {
using namespace archive;
namespace {

PackedModel model_of(Mesh mesh) {
  PackedModel model = tiny_packed_model();
  model.rest = std::move(mesh);
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  model.order.clear();
  model.row_blocks = {{0, rows, {{0, false, 0.5f}}, std::pmr::vector<std::int16_t>(rows, 1)}};
  return model;
}

void check_survives(const Mesh& mesh, const char* what) {
  INFO(what);
  const Mesh after = read_archive(write_archive(model_of(mesh), {})).model.rest;
  CHECK(same_bits(mesh.points, after.points));
  CHECK(mesh.polygon_sizes == after.polygon_sizes);
  CHECK(mesh.polygon_corners == after.polygon_corners);
  CHECK(mesh.uvs == after.uvs);
  CHECK(mesh.uv_corners == after.uv_corners);
}

// A number of a section's contents.
template <class T>
T stored(const Mesh& mesh, const char* section, std::size_t at) {
  ArchiveEditor archive(write_archive(model_of(mesh), {}));
  T number;
  std::memcpy(&number, archive[section].stored.data() + at, sizeof number);
  return number;
}

// The number of points that Draco holds.
std::uint32_t stored_points(const Mesh& mesh) {
  return stored<std::uint32_t>(mesh, "geometry", 0);
}
float stored_grid_step(const Mesh& mesh) {
  return stored<float>(mesh, "geometry", 8);
}
// The number of polygons that are coded along triangles.
std::size_t along_triangles(const Mesh& mesh) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < mesh.polygon_sizes.size(); ++p)
    count += stored<std::uint8_t>(mesh, "polygons", 8 + 4 * mesh.polygon_sizes.size() + p) != no_edge;
  return count;
}

void add_polygon(Mesh& mesh, std::vector<std::uint32_t> corners) {
  mesh.polygon_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
  mesh.polygon_corners.insert(mesh.polygon_corners.end(), corners.begin(), corners.end());
}

// A mesh of random points with these polygons.
Mesh mesh_of(std::size_t vertices, const std::vector<std::vector<std::uint32_t>>& polygons) {
  Random random(5);
  Mesh mesh;
  mesh.points = random_values(random, 3 * vertices, 10);
  for (const auto& polygon : polygons) add_polygon(mesh, polygon);
  return mesh;
}

// The same surface with its vertices in random order.
Mesh shuffled(const Mesh& mesh) {
  std::vector<std::uint32_t> place(mesh.vertex_count());
  std::iota(place.begin(), place.end(), 0u);
  Random random(9);
  for (std::size_t i = place.size(); i-- > 1;)
    std::swap(place[i], place[random.below(static_cast<std::uint32_t>(i + 1))]);
  Mesh out = mesh;
  for (std::size_t v = 0; v < place.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) out.points[3 * place[v] + axis] = mesh.points[3 * v + axis];
  for (auto& corner : out.polygon_corners) corner = place[corner];
  return out;
}

}  // namespace

TEST_CASE("a regular surface survives, through Draco's edgebreaker") {
  check_survives(grid_mesh(20, 30), "grid");
  check_survives(shuffled(grid_mesh(20, 30)), "shuffled grid");
  CHECK(stored_points(grid_mesh(20, 30)) == grid_mesh(20, 30).vertex_count());
  check_survives(mesh_of(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}), "closed surface");
}

TEST_CASE("polygons of a regular surface are coded along triangles, whatever their first corners") {
  Mesh mesh = shuffled(grid_mesh(20, 30));
  CHECK(along_triangles(mesh) == mesh.polygon_sizes.size());
  for (std::size_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    const auto polygon = mesh.polygon_corners.begin() + static_cast<std::ptrdiff_t>(4 * p);
    std::rotate(polygon, polygon + static_cast<std::ptrdiff_t>(p % 4), polygon + 4);
  }
  check_survives(mesh, "rotated polygons");
  CHECK(along_triangles(mesh) == mesh.polygon_sizes.size());
  // The largest number of edges of a vertex that can be coded, and one more.
  for (const std::uint32_t triangles : {64u, 65u}) {
    std::vector<std::vector<std::uint32_t>> fan;
    for (std::uint32_t t = 0; t < triangles; ++t) fan.push_back({0, 1 + t, 1 + (t + 1) % triangles});
    const Mesh cone = mesh_of(1 + triangles, fan);
    check_survives(cone, "cone");
    CHECK(along_triangles(cone) == (triangles == 64 ? triangles : 0));
  }
}

TEST_CASE("positions on a grid take fewer bytes and survive") {
  Mesh mesh = grid_mesh(20, 30);
  CHECK(stored_grid_step(mesh) == 0);
  const std::size_t before = write_archive(model_of(mesh), {}).size();
  for (float& x : mesh.points) x = std::round(x * 4096) / 4096;
  check_survives(mesh, "on a grid");
  CHECK(stored_grid_step(mesh) == 0x1p-12f);
  CHECK(write_archive(model_of(mesh), {}).size() + 2000 < before);
  mesh.polygon_sizes.clear();
  mesh.polygon_corners.clear();
  check_survives(mesh, "points on a grid");
  CHECK(stored_grid_step(mesh) == 0x1p-12f);
  mesh.points[4] = 0x1.fffffep11f;  // 16,777,215 steps
  check_survives(mesh, "the ends of the grid");
  CHECK(stored_grid_step(mesh) == 0x1p-12f);
  mesh.points[4] = 0x1p12f;
  check_survives(mesh, "beyond the ends of the grid");
  CHECK(stored_grid_step(mesh) == 0);
}

TEST_CASE("texture coordinates survive, with seams and one a vertex") {
  Mesh mesh = grid_mesh(20, 30);
  give_uvs(mesh);
  check_survives(mesh, "with a seam");
  CHECK(stored<UvCoding>(mesh, "uvs", 4) == UvCoding::deltas);
  give_uvs_by_vertex(mesh);
  check_survives(mesh, "one a vertex");
  CHECK(stored<UvCoding>(mesh, "uvs", 4) == UvCoding::by_vertex);
  std::swap(mesh.uv_corners[0], mesh.uv_corners[1]);
  check_survives(mesh, "two corners swapped");
  CHECK(stored<UvCoding>(mesh, "uvs", 4) == UvCoding::deltas);
  mesh.polygon_sizes.clear(), mesh.polygon_corners.clear(), mesh.uv_corners.clear();
  check_survives(mesh, "without polygons");
}

TEST_CASE("texture coordinates belong to the mesh part") {
  PackedModel model = model_of(grid_mesh(4, 4));
  give_uvs(model.rest);
  const Bytes bytes = write_archive(model, {});
  CHECK(read_archive(bytes, {}, Parts::mesh).model.rest.uvs == model.rest.uvs);
  CHECK(read_archive(bytes, {}, Parts::behaviour).model.rest.uvs.empty());
}

TEST_CASE("odd topology survives") {
  check_survives(mesh_of(5, {{0, 1, 2}, {1, 3, 2}}), "isolated vertex at the end");
  check_survives(mesh_of(5, {{1, 2, 3}, {2, 4, 3}}), "isolated vertex at the beginning");
  check_survives(mesh_of(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), "three triangles on one edge");
  check_survives(mesh_of(5, {{0, 1, 2}, {0, 3, 4}}), "bow tie");
  check_survives(mesh_of(4, {{0, 1, 2}, {1, 2, 3}}), "flipped winding");
  check_survives(mesh_of(4, {{0, 1, 2}, {0, 1, 2}, {1, 3, 2}}), "polygon twice");
  check_survives(mesh_of(4, {{0, 1, 2}, {2, 1, 0}, {1, 3, 2}}), "polygon and its back");
  check_survives(mesh_of(4, {{0, 1, 2}, {1, 1, 3}, {2, 2, 2}}), "degenerate polygons");
  check_survives(mesh_of(7, {{0, 1, 2}, {3, 4, 5, 6}}), "two islands");
  check_survives(mesh_of(2, {}), "two vertices without polygons");
  check_survives(mesh_of(500, {}), "points without polygons");
}

TEST_CASE("duplicate and seam vertices are not merged") {
  Mesh mesh = mesh_of(6, {{0, 1, 2}, {3, 5, 4}});
  for (int axis = 0; axis < 3; ++axis) {
    mesh.points[3 * 3 + axis] = mesh.points[3 * 1 + axis];
    mesh.points[3 * 4 + axis] = mesh.points[3 * 2 + axis];
  }
  check_survives(mesh, "seam of coincident vertices");
  Mesh same = grid_mesh(5, 5);
  for (std::size_t v = 1; v < 20; ++v) std::copy_n(same.points.begin(), 3, same.points.begin() + 3 * v);
  check_survives(same, "twenty vertices on one point");
}

TEST_CASE("polygons of every size keep their order and first corner") {
  Mesh mesh = mesh_of(40, {});
  std::uint32_t first = 3;
  for (std::uint32_t size = 3; size <= 12; ++size) {
    std::vector<std::uint32_t> corners;
    for (std::uint32_t k = 0; k < size; ++k) corners.push_back((first + 7 * k) % 40);
    add_polygon(mesh, corners);
    first += size;
  }
  check_survives(mesh, "sizes 3 to 12");
  std::vector<std::uint32_t> big(1000);
  std::iota(big.begin(), big.end(), 0u);
  std::rotate(big.begin(), big.begin() + 333, big.end());
  check_survives(mesh_of(1000, {{0, 1, 2}, big}), "a polygon of a thousand corners");
}

TEST_CASE("coordinates keep every bit") {
  Mesh mesh = grid_mesh(4, 4);
  const float odd[] = {-0.0f, 1e-45f, -1e-40f, 3e38f, -3e38f, 0x1.fffffep-1f};
  std::copy(std::begin(odd), std::end(odd), mesh.points.begin());
  check_survives(mesh, "signed zero, denormals, the largest numbers");
}

}  // namespace fb::test_rest_mesh
