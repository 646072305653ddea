// Planning levels of detail: simplified with attention to motion, or given as meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/levels/match_level_mesh.h"
#include "bake/levels/plan_levels.h"
#include "bake/levels/simplify_mesh.h"
#include "base/status.h"
#include "memory_source.h"

namespace test_plan_levels {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 25;

// A sheet whose right half is thrown into waves by one control, and whose left half another one lifts as a whole.
void waves(const float* controls, std::span<float> points) {
  for (std::size_t v = 0; v < points.size() / 3; ++v) {
    const float x = points[3 * v], right = std::max(0.0f, x - side / 2);
    points[3 * v + 2] += controls[0] * 1.5f * std::sin(1.7f * right) + controls[1] * 3;
  }
}

MemorySource sheet() {
  MemorySource source(2, side, waves);
  for (std::size_t z = 2; z < source.edit_rest().points.size(); z += 3) source.edit_rest().points[z] = 0;
  source.edit_rest().points[2] = 0.5f;
  source.add_clip("train", ClipKind::dense, Split::train, 60, 0.7f, 3);
  return source;
}

LevelPlan plan_of(Source& source, const BakeOptions& options, const Character& character = {}) {
  return plan_levels(training_poses(source, Use::backlot), character, options, silent_progress());
}

std::size_t count_at(const LevelPlan& plan, std::size_t level) {
  return static_cast<std::size_t>(std::count_if(plan.coarsest.begin(), plan.coarsest.end(),
                                                [&](std::uint8_t coarsest) { return coarsest >= level; }));
}

TEST_CASE("each level has about its share of the vertices, all of them in the level before it") {
  MemorySource source = sheet();
  BakeOptions options;
  options.level_shares = {0.5, 0.25};
  const LevelPlan plan = plan_of(source, options);
  REQUIRE(plan.levels.size() == 2);
  CHECK(count_at(plan, 1) == doctest::Approx(0.5 * side * side).epsilon(0.15));
  CHECK(count_at(plan, 2) == doctest::Approx(0.25 * side * side).epsilon(0.2));
  for (std::size_t k = 1; k <= 2; ++k) {
    std::set<std::uint32_t> corners(plan.levels[k - 1].polygon_corners.begin(),
                                    plan.levels[k - 1].polygon_corners.end());
    for (const std::uint32_t v : corners) CHECK(plan.coarsest[v] >= k);
    CHECK(corners.size() == count_at(plan, k));
  }
  const LevelPlan again = plan_of(source, options);
  CHECK(again.levels == plan.levels);
  CHECK(again.points == plan.points);
}

TEST_CASE("vertices stay where poses bend the surface, though it is flat at rest") {
  MemorySource source = sheet();
  BakeOptions options;
  options.level_shares = {0.3};
  const LevelPlan plan = plan_of(source, options);
  std::size_t left = 0, right = 0;
  for (std::size_t v = 0; v < side * side; ++v)
    if (plan.coarsest[v] == 1) ++(v % side < side / 2 ? left : right);
  CHECK(right > 3 * left);
}

// Distances along x and y, where vertices are 1 apart, of vertices that leave from where they were.
double mean_shift(const LevelPlan& plan, const std::vector<float>& points) {
  std::size_t count = 0;
  double sum = 0;
  for (std::uint32_t v = 0; v < side * side; ++v) {
    if (plan.coarsest[v] == 2) continue;
    const std::vector<std::uint32_t> triangles = plan.levels[plan.coarsest[v]].triangles();
    const SurfacePoint& point = plan.points[v];
    REQUIRE(point.triangle < triangles.size() / 3);
    REQUIRE(point.weights[0] + point.weights[1] <= 256);
    const double weights[3] = {(256.0 - point.weights[0] - point.weights[1]) / 256, point.weights[0] / 256.0,
                               point.weights[1] / 256.0};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double at = 0;
      for (std::size_t c = 0; c < 3; ++c) at += weights[c] * points[3 * triangles[3 * point.triangle + c] + axis];
      sum += std::abs(at - points[3 * v + axis]), ++count;
    }
  }
  return sum / double(count);
}

TEST_CASE("vertices that leave lie on the surface near where they were, with any seed") {
  MemorySource source = sheet();
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    BakeOptions options;
    options.seed = seed;
    options.level_shares = {0.5, 0.25};
    // 0.02 to 0.13; corners of the sheet may leave, and their vertices then move furthest.
    CHECK(mean_shift(plan_of(source, options), source.rest().points) < 0.19);
  }
}

TEST_CASE("vertices of sockets, and those without polygons, are in every level") {
  MemorySource source = sheet();
  source.edit_rest().points.insert(source.edit_rest().points.end(), {3, 3, 3});
  Character character;
  character.sockets = {{"here", {7, 8, 9, 10, 11}, {1, 1, 1, 1, 1}}};
  BakeOptions options;
  options.level_shares = {0.2, 0.05};
  const LevelPlan plan = plan_of(source, options, character);
  for (const std::uint32_t v : {7, 8, 9, 10, 11, int(side * side)}) CHECK(plan.coarsest[v] == 2);
}

// Cuts the sheet into two materials, and its texture along a seam of the same column.
void divide(Mesh& mesh) {
  mesh.parts = {{"sheet", side * side, (side - 1) * (side - 1), {}}};
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    mesh.parts[0].materials.push_back({10, 0});
    mesh.parts[0].materials.push_back({side - 11, 1});
  }
  const std::size_t vertices = side * side;
  for (std::size_t copy = 0; copy < 2; ++copy)
    for (std::size_t v = 0; v < vertices; ++v)
      mesh.uvs.insert(mesh.uvs.end(), {float(v % side) / 50 + 0.5f * float(copy), float(v / side) / 25});
  for (std::size_t c = 0; c < mesh.polygon_corners.size(); ++c)
    mesh.uv_corners.push_back(mesh.polygon_corners[c] +
                              (c / 4 % (side - 1) >= 10 ? static_cast<std::uint32_t>(vertices) : 0));
}

TEST_CASE("polygons of a level keep materials and texture coordinates") {
  MemorySource source = sheet();
  Mesh& mesh = source.edit_rest();
  divide(mesh);
  // Runs of one material are joined, in the order of polygons.
  std::vector<std::uint32_t> order(mesh.polygon_sizes.size());
  for (std::uint32_t p = 0; p < order.size(); ++p) order[p] = p;
  std::stable_sort(order.begin(), order.end(),
                   [](std::uint32_t a, std::uint32_t b) { return (a % (side - 1) >= 10) < (b % (side - 1) >= 10); });
  Mesh sorted = mesh;
  for (std::uint32_t p = 0; p < order.size(); ++p)
    for (std::uint32_t k = 0; k < 4; ++k) {
      sorted.polygon_corners[4 * p + k] = mesh.polygon_corners[4 * order[p] + k];
      sorted.uv_corners[4 * p + k] = mesh.uv_corners[4 * order[p] + k];
    }
  sorted.parts[0].materials = {{10 * (side - 1), 0}, {(side - 11) * (side - 1), 1}};
  mesh = sorted;
  BakeOptions options;
  options.level_shares = {0.4};
  const LevelPlan plan = plan_of(source, options);
  const DetailLevel& level = plan.levels[0];
  REQUIRE(level.parts.size() == 1);
  REQUIRE(level.parts[0].materials.size() == 2);
  CHECK(level.parts[0].materials[0].material == 0);
  CHECK(level.parts[0].materials[1].material == 1);
  CHECK(level.parts[0].materials[0].polygons + level.parts[0].materials[1].polygons == level.polygon_sizes.size());
  for (std::size_t c = 0; c < level.polygon_corners.size(); ++c) {
    const bool second = c / 3 >= level.parts[0].materials[0].polygons;
    CHECK(level.uv_corners[c] == level.polygon_corners[c] + (second ? side * side : 0));
    CHECK((second ? level.polygon_corners[c] % side >= 10 : level.polygon_corners[c] % side <= 10));
  }
}

TEST_CASE("given meshes are matched by position, with texture coordinates and materials") {
  MemorySource source = sheet();
  divide(source.edit_rest());
  const Mesh& rest = source.rest();
  Mesh given;
  given.points = {0, 0, 0.5f, 24, 0, 0, 24, 24, 1e-4f, 0, 24, 0, 12, 12, 0};
  given.polygon_sizes = {3, 3, 4};
  given.polygon_corners = {0, 1, 4, 1, 2, 4, 0, 4, 2, 3};
  const std::vector<std::uint32_t> kept = {5};
  const std::vector<LevelMesh> meshes = {{given, "far.obj"}};
  const LevelPlan plan = matched_levels(rest, meshes, kept);
  REQUIRE(plan.levels.size() == 1);
  CHECK(count_at(plan, 1) == 6);
  CHECK(plan.coarsest[24 * side + 24] == 1);
  CHECK(plan.coarsest[5] == 1);
  CHECK(plan.levels[0].parts[0].polygons == 3);
  CHECK(plan.levels[0].uv_corners.size() == 10);
  for (std::size_t c = 0; c < 10; ++c)
    CHECK(plan.levels[0].uv_corners[c] % (side * side) == plan.levels[0].polygon_corners[c]);

  Mesh wrong = given;
  wrong.points[3] = 23.5f;
  const std::vector<LevelMesh> no_vertex = {{given, "far.obj"}, {wrong, "farther.obj"}};
  CHECK_THROWS_WITH_AS(matched_levels(rest, no_vertex, {}),
                       doctest::Contains("farther.obj: vertex 1 at (23.5, 0, 0) is no vertex of the character"), Error);
  MemorySource two = sheet();
  two.edit_rest().parts = {{"a", 24 * side, 23 * (side - 1)}, {"b", side, 0}};
  two.edit_rest().polygon_sizes.resize(23 * (side - 1));
  two.edit_rest().polygon_corners.resize(4 * 23 * (side - 1));
  two.edit_rest().polygon_sizes.push_back(3);
  two.edit_rest().polygon_corners.insert(two.edit_rest().polygon_corners.end(), {600, 601, 602});
  two.edit_rest().parts[1].polygons = 1;
  Mesh across = given;
  across.points[6] = 2;
  const std::vector<LevelMesh> both = {{across, "far.obj"}};
  CHECK_THROWS_WITH_AS(matched_levels(two.rest(), both, {}), doctest::Contains("has vertices of two meshes"), Error);
}

TEST_CASE("levels that cannot be are refused") {
  MemorySource source = sheet();
  for (const std::vector<double>& shares :
       {std::vector<double>{1}, {0.5, 0.5}, {0.5, 0.6}, {0.0}, {-1.0}, {NAN}, {0.5, NAN}}) {
    BakeOptions options;
    options.level_shares = shares;
    CHECK_THROWS_WITH_AS(plan_of(source, options), doctest::Contains("shares are between 0 and 1 and fall"), Error);
  }
  BakeOptions options;
  options.level_shares = {0.5};
  options.level_meshes = {"far.obj"};
  CHECK_THROWS_WITH_AS(plan_of(source, options), doctest::Contains("either given as meshes or made"), Error);
  options.level_shares.clear();
  CHECK_THROWS_WITH_AS(plan_of(source, options), doctest::Contains("far.obj"), Error);
  CHECK(plan_of(source, {}).empty());
}

}  // namespace

}  // namespace test_plan_levels
