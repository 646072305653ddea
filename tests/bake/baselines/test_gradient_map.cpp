#include "bake/baselines/gradient_map.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "memory_source.h"

namespace test_gradient_map {

using namespace fb;
using namespace fb::bake;

namespace {

void wave(const float* c, std::span<float> points) {
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += c[0] * std::sin(0.2f * float(i)) + c[1] * float(i % 3);
}

// Two sheets, one above the other, two vertices without polygons, and a triangle without area.
Mesh broken_mesh() {
  const MemorySource sheet(2, 6, wave);
  Mesh mesh = sheet.rest();
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  for (std::uint32_t v = 0; v < count; ++v)
    for (int axis = 0; axis < 3; ++axis) mesh.points.push_back(sheet.rest().points[3 * v + axis] + (axis == 2 ? 2 : 0));
  for (const std::uint32_t corner : sheet.rest().polygon_corners) mesh.polygon_corners.push_back(corner + count);
  mesh.polygon_sizes.insert(mesh.polygon_sizes.end(), sheet.rest().polygon_sizes.begin(),
                            sheet.rest().polygon_sizes.end());
  mesh.points.insert(mesh.points.end(), {9, 9, 9, 8, 8, 8});
  mesh.polygon_sizes.push_back(3);
  mesh.polygon_corners.insert(mesh.polygon_corners.end(), {0, 1, 2});
  return mesh;
}

std::vector<float> round_trip(const GradientMap& map, const std::vector<float>& displacements) {
  std::vector<float> gradients(displacements.size()), back(displacements.size());
  map.to_gradients(displacements, gradients);
  map.to_displacements(gradients, back);
  return back;
}

}  // namespace

TEST_CASE("positions are reconstructed from gradients and mean translations") {
  const Mesh mesh = broken_mesh();
  const GradientMap map(mesh);
  CHECK(map.component_count() == 4);
  std::vector<float> displacements(mesh.points.size());
  for (std::size_t i = 0; i < displacements.size(); ++i)
    displacements[i] = std::sin(0.3f * float(i)) + (i < displacements.size() / 2 ? 2.0f : -1.0f);
  const std::vector<float> back = round_trip(map, displacements);
  for (std::size_t i = 0; i < back.size(); ++i) CHECK(back[i] == doctest::Approx(displacements[i]).epsilon(1e-4));
}

TEST_CASE("the length of a pose is that of its triangles' gradients and its components' translations") {
  const MemorySource sheet(2, 7, wave);
  const Mesh& mesh = sheet.rest();
  const GradientMap map(mesh);
  // A linear deformation has one gradient everywhere; here it stretches x by .5 and shears y along x by .25.
  std::vector<float> displacements(mesh.points.size()), gradients(mesh.points.size());
  double area = 0;
  std::array<double, 3> mean = {0, 0, 0};
  const std::vector<std::uint32_t> corners = mesh.triangles();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    displacements[3 * v] = 0.5f * mesh.points[3 * v];
    displacements[3 * v + 1] = 0.25f * mesh.points[3 * v];
  }
  double expected = 0;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    const auto edge = [&](int corner, int axis) {
      return double(mesh.points[3 * corners[t + corner] + axis]) - mesh.points[3 * corners[t] + axis];
    };
    std::array<double, 3> normal;
    for (int a = 0; a < 3; ++a)
      normal[a] = edge(1, (a + 1) % 3) * edge(2, (a + 2) % 3) - edge(1, (a + 2) % 3) * edge(2, (a + 1) % 3);
    const double twice = std::hypot(normal[0], normal[1], normal[2]), across = normal[0] / twice;
    area += twice / 2;
    // Of the gradient (.5, .25, 0) of x only the part in the triangle's plane counts.
    expected += twice / 2 * (0.25 + 0.0625) * (1 - across * across);
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis) mean[axis] += twice / 6 * displacements[3 * corners[t + corner] + axis];
  }
  const double unit = GradientMap::translation_length * mesh.diagonal();
  for (const double sum : mean) expected += sum * sum / area / (unit * unit);
  map.to_gradients(displacements, gradients);
  double length = 0;
  for (const float g : gradients) length += double(g) * g;
  CHECK(length == doctest::Approx(expected).epsilon(1e-5));
}

TEST_CASE("a mesh without polygons has translations only") {
  MemorySource source(2, 4, wave);
  source.edit_rest().polygon_sizes.clear();
  source.edit_rest().polygon_corners.clear();
  const GradientMap map(source.rest());
  CHECK(map.component_count() == 16);
  std::vector<float> displacements(source.rest().points.size());
  for (std::size_t i = 0; i < displacements.size(); ++i) displacements[i] = std::cos(float(i));
  const std::vector<float> back = round_trip(map, displacements);
  for (std::size_t i = 0; i < back.size(); ++i) CHECK(back[i] == doctest::Approx(displacements[i]).epsilon(1e-6));
}

TEST_CASE("gradients of poses are read the same by any number of threads") {
  MemorySource source(2, 6, wave);
  source.add_clip("poses", ClipKind::dense, Split::train, 20, 1, 1);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const GradientMap map(source.rest());
  const GradientRows rows(poses, map);
  std::vector<float> one(rows.rows() * 20), three(one.size()), first(rows.rows()), moved(rows.rows());
  rows.read(0, 20, one, {.threads = 1});
  rows.read(0, 20, three, {.threads = 3});
  CHECK(one == three);
  poses.read_displacements(0, 1, moved);
  map.to_gradients(moved, first);
  CHECK(std::equal(first.begin(), first.end(), one.begin()));
}

}  // namespace test_gradient_map
