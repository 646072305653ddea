// Closest points of a tree against those of all triangles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/status.h"
#include "head_meshes.h"
#include "solve/open_border.h"
#include "solve/sampled_surface.h"
#include "solve/triangle_tree.h"

using namespace fb;
using namespace fb::tool;
using namespace fb::test;

namespace test_closest_points {

// The distance to a triangle, by trying its plane, its edges and its corners.
double distance_to(Vector3 p, Vector3 a, Vector3 b, Vector3 c) {
  const Vector3 n = normalized(cross(b - a, c - a));
  const double off = dot(p - a, n);
  const Vector3 on = p - n * float(off);
  const auto inside = [&](Vector3 from, Vector3 to) { return dot(cross(to - from, on - from), n) >= 0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(off);
  double least = 1e30;
  for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
    const float along = std::clamp(dot(p - from, to - from) / dot(to - from, to - from), 0.0f, 1.0f);
    least = std::min(least, double(length(p - mix(from, to, along))));
  }
  return least;
}

struct Scattered {
  std::vector<float> points;
  std::vector<std::uint32_t> triangles;
};

Scattered scattered(std::uint32_t count) {
  Random random(5);
  Scattered mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vector3 middle = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
    for (std::uint32_t k = 0; k < 3; ++k) {
      mesh.points.insert(mesh.points.end(),
                         {middle.x + random.uniform(-0.4f, 0.4f), middle.y + random.uniform(-0.4f, 0.4f),
                          middle.z + random.uniform(-0.4f, 0.4f)});
      mesh.triangles.push_back(3 * t + k);
    }
  }
  return mesh;
}

TEST_CASE("a tree finds the closest point of all triangles") {
  const Scattered mesh = scattered(300);
  const TriangleTree tree(mesh.points, mesh.triangles);
  Random random(7);
  double worst = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3 p = {random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4)};
    double least = 1e30;
    for (std::size_t t = 0; t < 300; ++t)
      least =
          std::min(least, distance_to(p, vector_at(mesh.points.data(), 3 * t), vector_at(mesh.points.data(), 3 * t + 1),
                                      vector_at(mesh.points.data(), 3 * t + 2)));
    const auto found = tree.closest(p);
    REQUIRE(found);
    worst = std::max(worst, std::abs(least - double(found->distance)));
    CHECK(length(found->surface.at(mesh.points) - found->position) < 1e-6f);
    for (const float weight : found->surface.weights) CHECK(weight >= -1e-6f);
    const auto limited = tree.closest(p, {.most_distance = found->distance * 0.99f});
    CHECK_FALSE(limited);
  }
  CHECK(worst < 1e-5);
}

TEST_CASE("only triangles that face a direction count where one is given") {
  // Two squares, one over the other, that look at each other.
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
  const std::vector<std::uint32_t> triangles = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6};
  const TriangleTree tree(points, triangles);
  CHECK(tree.closest({0.5f, 0.4f, 0.2f})->position.z == 0);
  CHECK(tree.closest({0.5f, 0.4f, 0.2f}, {.normal = Vector3{0, 0, -1}})->position.z == 1);
  CHECK_FALSE(tree.closest({0.5f, 0.4f, 0.2f}, {.normal = Vector3{1, 0, 0}}));
}

TEST_CASE("a mesh without a surface, or with what is no vertex, is refused") {
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 2, 0, 0}, bad = {0, 0, NAN, 1, 0, 0, 0, 1, 0};
  const std::vector<std::uint32_t> triangle = {0, 1, 2}, beyond = {0, 1, 3};
  CHECK_THROWS_WITH_AS(TriangleTree(points, triangle), "the mesh has no surface: no triangle has an area", Error);
  CHECK_THROWS_WITH_AS(TriangleTree(bad, triangle), "vertex 0 of the mesh has no position", Error);
  CHECK_THROWS_WITH_AS(TriangleTree(points, beyond), "triangle 0 of the mesh has a vertex 3, of 3", Error);
}

TEST_CASE("a border is where a surface ends, not where vertices are doubled") {
  // Two squares side by side, whose common edge has a vertex of each.
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0};
  const std::vector<std::uint32_t> triangles = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
  const TriangleTree tree(points, triangles);
  const OpenBorder border(points, triangles);
  const auto at = [&](Vector3 p) { return border.has(*tree.closest(p)); };
  CHECK(border.any());
  CHECK(at({-1, 0.5f, 0}));
  CHECK(at({1.5f, 2, 0}));
  CHECK(at({-1, -1, 0}));
  CHECK_FALSE(at({1, 0.5f, 1}));
  CHECK_FALSE(at({0.4f, 0.5f, 1}));

  const std::vector<float> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<std::uint32_t> closed = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  CHECK_FALSE(OpenBorder(corners, closed).any());
}

TEST_CASE("samples lie on the surface, evenly by area") {
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 8, 0, 0, 5, 3, 0};
  const std::vector<std::uint32_t> triangles = {0, 1, 2, 3, 4, 5};
  const SurfaceSamples samples = sample_surface(points, triangles, 1000);
  REQUIRE(samples.points.size() == 1000);
  const auto small = std::ranges::count_if(samples.points, [](Vector3 p) { return p.x < 2; });
  CHECK(small == 100);
  for (std::size_t i = 0; i < 1000; ++i) {
    const Vector3 p = samples.points[i];
    CHECK((p.x < 2 ? p.x + p.y <= 1.0001f : p.x - 5 + p.y <= 3.0001f));
    CHECK(samples.normals[i].z == 1);
  }
}

}  // namespace test_closest_points
