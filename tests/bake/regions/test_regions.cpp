#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "bake/regions/find_regions.h"
#include "bake/regions/surface_graph.h"
#include "bake/regions/weighted_kmeans.h"
#include "base/status.h"
#include "test_models.h"

namespace test_regions {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::uint32_t side = 24;

RigSchema controls(const std::vector<std::string>& groups) {
  RigSchema schema;
  schema.name = "planted";
  for (std::size_t c = 0; c < groups.size(); ++c)
    schema.controls.push_back({"control" + std::to_string(c), 0, 1, 0, groups[c]});
  return schema;
}

std::vector<float> plant(const RigSchema& schema, const Mesh& mesh,
                         const std::function<double(std::size_t control, std::size_t vertex)>& motion) {
  std::vector<float> values;
  for (std::size_t c = 0; c < schema.control_count(); ++c)
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) values.push_back(float(motion(c, v)));
  return values;
}

std::size_t quadrant(std::size_t vertex) {
  return (vertex % side >= side / 2) + 2 * (vertex / side >= side / 2);
}

// A region's weight of every vertex of the mesh.
std::vector<float> dense_weights(const FaceRegion& region, std::size_t vertices) {
  std::vector<float> weights(vertices, 0);
  for (std::size_t i = 0; i < region.vertices.size(); ++i) weights[region.vertices[i]] = region.weights[i];
  return weights;
}

std::vector<int> regions_per_vertex(const std::vector<FaceRegion>& regions, std::size_t vertices) {
  std::vector<int> count(vertices, 0);
  for (const FaceRegion& region : regions)
    for (const std::uint32_t v : region.vertices) ++count[v];
  return count;
}

// Two meshes as one, not connected.
Mesh merge_meshes(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  mesh.points.insert(mesh.points.end(), b.points.begin(), b.points.end());
  mesh.polygon_sizes.insert(mesh.polygon_sizes.end(), b.polygon_sizes.begin(), b.polygon_sizes.end());
  for (const std::uint32_t corner : b.polygon_corners)
    mesh.polygon_corners.push_back(corner + std::uint32_t(a.vertex_count()));
  return mesh;
}

bool same(const std::vector<FaceRegion>& a, const std::vector<FaceRegion>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const FaceRegion& x, const FaceRegion& y) {
    return x.name == y.name && x.vertices == y.vertices && x.weights == y.weights && x.controls == y.controls &&
           x.energy == y.energy;
  });
}

template <class Work>
Status failure(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.status();
  }
  return Status::ok;
}

}  // namespace

TEST_CASE("vertices moved by the same controls form a region with those controls as inputs") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"brow", "brow", "mouth", "nose", "brow"});
  // The last control moves every vertex by less than the threshold.
  const std::vector<float> motion = plant(schema, mesh, [](std::size_t c, std::size_t v) {
    return c == 4 ? 5e-5 : quadrant(v) == c ? 0.01 * double(c + 1) : 0.0;
  });
  const std::vector<FaceRegion> regions = find_regions(mesh, schema, motion, {.regions = 4, .overlap = 0});
  REQUIRE(regions.size() == 4);
  double energy = 0;
  for (std::size_t r = 0; r < 4; ++r) {
    const std::size_t planted = 3 - r;  // by falling energy
    const std::vector<float> weights = dense_weights(regions[r], mesh.vertex_count());
    for (std::size_t v = 0; v < weights.size(); ++v) {
      INFO("region ", r, " vertex ", v);
      CHECK((weights[v] > 0.5f) == (quadrant(v) == planted));
    }
    CHECK(regions[r].controls == std::vector<std::uint32_t>{std::uint32_t(planted)});
    CHECK(std::is_sorted(regions[r].vertices.begin(), regions[r].vertices.end()));
    if (r > 0) CHECK(regions[r].energy < regions[r - 1].energy);
    energy += regions[r].energy;
  }
  CHECK(energy == doctest::Approx(1));
  CHECK(regions[0].name == "nose");
  CHECK(regions[1].name == "mouth");
  CHECK(regions[2].name == "brow");
  CHECK(regions[3].name == "brow 2");
}

TEST_CASE("weights are a smooth partition of unity in a narrow band") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"a", "b", "c", "d"});
  const std::vector<float> motion =
      plant(schema, mesh, [](std::size_t c, std::size_t v) { return quadrant(v) == c ? 0.01 : 0.0; });
  const double diagonal = mesh.diagonal();
  const std::vector<FaceRegion> regions = find_regions(mesh, schema, motion, {.regions = 4, .overlap = 0.2});
  std::vector<double> sums(mesh.vertex_count(), 0);
  const SurfaceGraph graph(mesh, {});
  for (const FaceRegion& region : regions) {
    const std::vector<float> weights = dense_weights(region, mesh.vertex_count());
    for (std::uint32_t v = 0; v < weights.size(); ++v) {
      sums[v] += weights[v];
      // The smoothstep has slope 1.5 over the band at most; three and four regions meet in the middle.
      for (const SurfaceGraph::Edge& edge : graph.edges(v))
        CHECK(std::abs(weights[v] - weights[edge.vertex]) <= 2 * 1.5 * edge.length / (0.2 * diagonal));
      const double reach = 0.1 * diagonal + 1.5;  // half the band, and an edge
      const double dx = std::abs(double(v % side) - (side - 1) / 2.0),
                   dy = std::abs(double(v / side) - (side - 1) / 2.0);
      if (dx > reach && dy > reach) CHECK((weights[v] == 0 || weights[v] == 1));
    }
    CHECK(region.controls.size() > 1);  // through the band, those of neighbours too
  }
  for (const double sum : sums) CHECK(sum == doctest::Approx(1).epsilon(1e-5));

  const std::vector<FaceRegion> hard = find_regions(mesh, schema, motion, {.regions = 4, .overlap = 0});
  for (const int count : regions_per_vertex(hard, mesh.vertex_count())) CHECK(count == 1);
  // A band narrower than the edges still shares one row of vertices on either side.
  const std::vector<FaceRegion> thin = find_regions(mesh, schema, motion, {.regions = 4, .overlap = 1e-4});
  const std::vector<int> shared = regions_per_vertex(thin, mesh.vertex_count());
  CHECK(shared[side / 2] == 2);
  CHECK(shared[side / 2 - 1] == 2);
  CHECK(shared[side / 2 + 4] == 1);
}

TEST_CASE("sheets that touch but are not joined share nothing") {
  const Mesh upper = grid_mesh(side, side);
  const Mesh mesh = merge_meshes(upper, upper);
  const RigSchema schema = controls({"upper", "lower"});
  const std::vector<float> motion = plant(
      schema, mesh, [&](std::size_t c, std::size_t v) { return (v >= upper.vertex_count()) == (c == 1) ? 0.01 : 0.0; });
  const std::vector<FaceRegion> regions = find_regions(mesh, schema, motion, {.regions = 2, .overlap = 0.3});
  REQUIRE(regions.size() == 2);
  for (const FaceRegion& region : regions) {
    CHECK(region.vertices.size() == upper.vertex_count());
    CHECK(region.controls.size() == 1);
    for (const float weight : region.weights) CHECK(weight == 1);
  }
}

TEST_CASE("a border does not tear vertices that were split at one place") {
  // The same sheet twice, moved alike: only position could tell its copies apart, and they have the same.
  const Mesh half = grid_mesh(side, side);
  const Mesh mesh = merge_meshes(half, half);
  const RigSchema schema = controls({"a", "b", "c", "d"});
  const std::vector<float> motion = plant(
      schema, mesh, [&](std::size_t c, std::size_t v) { return quadrant(v % half.vertex_count()) == c ? 0.01 : 0.0; });
  for (const FaceRegion& region : find_regions(mesh, schema, motion, {.regions = 4, .overlap = 0.1})) {
    const std::vector<float> weights = dense_weights(region, mesh.vertex_count());
    for (std::size_t v = 0; v < half.vertex_count(); ++v) CHECK(weights[v] == weights[v + half.vertex_count()]);
  }
}

TEST_CASE("small components join the surrounding region") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"left", "right"});
  const auto island = [](std::size_t v) { return v / side >= 10 && v / side < 12 && v % side >= 3 && v % side < 6; };
  const std::vector<float> motion = plant(schema, mesh, [&](std::size_t c, std::size_t v) {
    return (island(v) || v % side >= side / 2) == (c == 1) ? 0.01 : 0.0;
  });
  const std::vector<FaceRegion> regions = find_regions(mesh, schema, motion, {.regions = 2, .overlap = 0});
  REQUIRE(regions.size() == 2);
  for (const FaceRegion& region : regions) CHECK(region.vertices.size() == side * side / 2);
  CHECK(regions[1].controls.size() + regions[0].controls.size() == 3);  // the island's control moves both
}

TEST_CASE("vertices that no control moves are in no region") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"a", "b"});
  // The motion falls off across the sheet; the second control moves a corner by less than the threshold.
  const std::vector<float> motion = plant(schema, mesh, [](std::size_t c, std::size_t v) {
    if (c == 1) return v / side > 20 && v % side > 20 ? 8e-5 : 0.0;
    return 0.01 * std::exp(-double(v % side));
  });
  const std::vector<FaceRegion> regions = find_regions(mesh, schema, motion, {.regions = 3});
  const std::vector<int> count = regions_per_vertex(regions, mesh.vertex_count());
  for (std::size_t v = 0; v < count.size(); ++v) {
    INFO("vertex ", v);
    if (motion[v] > 1e-5f) CHECK(count[v] > 0);
    if (motion[v] < 1e-5f) CHECK(count[v] == 0);
  }
  for (const FaceRegion& region : regions) CHECK(region.controls == std::vector<std::uint32_t>{0});
  const std::vector<float> none(motion.size(), 0);
  CHECK(find_regions(mesh, schema, none, {}).empty());
}

TEST_CASE("small clusters are merged, and the result depends on the seed only") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"a", "b", "c", "d"});
  Random random(5);
  const std::vector<float> motion = plant(schema, mesh, [&](std::size_t c, std::size_t v) {
    return (quadrant(v) == c ? 0.01 : 0.001) * random.uniform(0.5f, 1.0f);
  });
  const std::vector<FaceRegion> once = find_regions(mesh, schema, motion, {.regions = 7, .seed = 3});
  CHECK(same(once, find_regions(mesh, schema, motion, {.regions = 7, .seed = 3})));
  CHECK(once.size() <= 7);
  CHECK(find_regions(mesh, schema, motion, {.regions = 500}).size() <= mesh.vertex_count() / 12);
  CHECK(find_regions(mesh, schema, motion, {.regions = 1}).size() == 1);
}

TEST_CASE("the number of regions follows the number of interacting controls, unless given") {
  const Mesh mesh = grid_mesh(side, side);
  const auto found = [&](std::size_t count, std::uint32_t asked) {
    const RigSchema schema = controls(std::vector<std::string>(count, "face"));
    // Each control moves a column of its own; every second one by less than the threshold.
    const std::vector<float> motion = plant(schema, mesh, [&](std::size_t c, std::size_t v) {
      return (v % side) * count / side == c / 2 ? (c % 2 ? 5e-5 : 0.01) : 0.0;
    });
    return find_regions(mesh, schema, motion, {.regions = asked}).size();
  };
  CHECK(found(40, 0) == 3);
  CHECK(found(40, 6) == 6);
}

TEST_CASE("motions that do not fit the rig are refused") {
  const Mesh mesh = grid_mesh(side, side);
  const RigSchema schema = controls({"a"});
  std::vector<float> motion(mesh.vertex_count(), 0.01f);
  CHECK(failure([&] { find_regions(mesh, schema, std::span(motion).first(3), {}); }) == Status::invalid_argument);
  CHECK(failure([&] { find_regions(mesh, schema, motion, {.motion_threshold = 0}); }) == Status::invalid_argument);
  CHECK(failure([&] { find_regions(mesh, schema, motion, {.overlap = NAN}); }) == Status::invalid_argument);
  motion[7] = NAN;
  CHECK(failure([&] { find_regions(mesh, schema, motion, {}); }) == Status::not_finite);
}

TEST_CASE("weighted means attract clusters to heavy points") {
  // Two far pairs, and in one of them a point so heavy that the mean lies on it.
  const std::vector<float> points = {0, 0, 1, 0, 100, 0, 101, 0};
  const std::vector<double> weights = {1, 1, 1, 1e6};
  const std::vector<std::uint32_t> two = weighted_kmeans(points, 2, weights, {.clusters = 2});
  CHECK(two[0] == two[1]);
  CHECK(two[2] == two[3]);
  CHECK(two[0] != two[2]);
  const std::vector<std::uint32_t> few = weighted_kmeans(points, 2, weights, {.clusters = 3, .min_cluster_size = 2});
  for (const std::uint32_t label : few) CHECK(std::count(few.begin(), few.end(), label) >= 2);
  const std::vector<double> nothing(4, 0);
  CHECK(weighted_kmeans(points, 2, nothing, {.clusters = 2}) == std::vector<std::uint32_t>(4, 0));
}

TEST_CASE("geodesic distances follow edges") {
  const Mesh mesh = grid_mesh(side, side);
  const SurfaceGraph graph(mesh, {});
  std::vector<double> distance(mesh.vertex_count(), INFINITY);
  std::vector<char> passable(mesh.vertex_count(), 1);
  for (std::size_t v = 0; v < passable.size(); ++v)  // a wall with a door at the far end
    if (v % side == side / 2 && v / side != side - 1) passable[v] = 0;
  distance[0] = 0;
  graph.geodesic_distances(distance, passable, 1.0,
                           1e9);  // edges count as 1 at most, and none is shorter by more than a tenth
  CHECK(distance[side - 1] > 0.9 * (3 * (side - 1) - 1));
  CHECK(distance[side - 1] <= 3 * (side - 1));
  CHECK(distance[side / 2] == INFINITY);
}

}  // namespace test_regions
