// Levels of detail: what is computed at each, that positions are continuous in between, and that outputs agree.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_detail_levels {

using namespace fb;
using namespace fb::runtime;

namespace {

constexpr std::size_t vertices = 30, floats = 3 * vertices;

std::vector<float> poses_of(const PackedModel& model, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> controls;
  for (int p = 0; p < count; ++p) {
    const std::vector<float> pose = random_pose(model.schema, random);
    controls.insert(controls.end(), pose.begin(), pose.end());
  }
  return controls;
}

// The positions of one pose at a level, in a workspace that may have been used.
std::vector<float> pose_at(const Evaluator& face, std::span<const float> pose, float lod, Workspace& workspace,
                           VertexOrder order = VertexOrder::source) {
  std::vector<float> positions(floats);
  Batch batch{.poses = 1, .controls = pose, .positions = {positions.data(), floats}, .order = order};
  batch.masks.lod = lod;
  face.evaluate_batch(batch, {&workspace, 1});
  return positions;
}

std::vector<float> pose_at(const Evaluator& face, std::span<const float> pose, float lod) {
  Workspace workspace(face);
  return pose_at(face, pose, lod, workspace);
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

double distance(const std::vector<float>& a, const std::vector<float>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(double(a[i]) - b[i]));
  return most;
}

// Positions by the formula, in binary64: basis times coefficients, those that the level does not use left out.
std::vector<double> exact_positions(const PackedModel& model, const Evaluator& face, const std::vector<float>& pose,
                                    const std::vector<double>& shares) {
  Workspace workspace(face);
  std::vector<float> coefficients(face.coefficient_count());
  face.coefficients(pose.data(), coefficients.data(), workspace);
  std::vector<double> positions(model.rest.points.begin(), model.rest.points.end());
  for (const PackedRowBlock& block : model.row_blocks)
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const std::vector<float> column = displacements(block, c);
      const std::uint32_t number = block.columns[c].column;
      for (std::uint32_t i = 0; i < block.row_count; ++i)
        positions[model.coordinate(block.first_row + i)] += shares[number] * coefficients[number] * column[i];
    }
  return positions;
}

TEST_CASE("at level 0, and of a face without levels at any, poses have the same bits as without levels") {
  const PackedModel model = levelled_model();
  PackedModel plain = model;
  plain.levels.clear();
  const Evaluator face(model), other(plain);
  CHECK(face.level_count() == 3);
  CHECK(face.level_vertices(1) == 19);
  CHECK(other.level_count() == 1);
  const std::vector<float> controls = poses_of(model, 6, 4);
  for (std::size_t p = 0; p < 6; ++p) {
    const auto pose = std::span(controls).subspan(p * face.control_count(), face.control_count());
    const std::vector<float> expected = pose_at(other, pose, 0);
    CHECK(same_bits(pose_at(face, pose, 0), expected));
    CHECK(same_bits(pose_at(other, pose, 1.5f), expected));
    Workspace workspace(face);
    std::vector<float> positions(floats);
    face.evaluate(pose.data(), positions.data(), workspace);
    CHECK(same_bits(positions, expected));
  }
}

TEST_CASE("a level has its own vertices by the coefficients it uses, and all others on its surface") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 5);
  const std::vector<std::vector<double>> shares = {{1, 1, 1, 1, 0}, {1, 1, 1, 0, 0}};
  for (std::size_t k = 1; k <= 2; ++k) {
    const std::vector<float> at = pose_at(face, pose, static_cast<float>(k));
    const std::vector<double> exact = exact_positions(model, face, pose, shares[k - 1]);
    for (std::size_t i = 0; i < 3 * std::size_t(model.levels[k - 1].vertices); ++i)
      CHECK(at[model.coordinate(static_cast<std::uint32_t>(i))] ==
            doctest::Approx(exact[model.coordinate(static_cast<std::uint32_t>(i))]).epsilon(1e-3));
    std::uint32_t baked = model.levels[k - 1].vertices;
    for (std::size_t from = k; from > 0; --from) {
      const std::vector<std::uint32_t> triangles = model.levels[from - 1].triangles();
      for (const SurfacePoint& point : model.levels[from - 1].points) {
        const float weights[3] = {float(256 - point.weights[0] - point.weights[1]) / 256, float(point.weights[0]) / 256,
                                  float(point.weights[1]) / 256};
        const std::uint32_t* corner = &triangles[3 * std::size_t(point.triangle)];
        const std::uint32_t v = model.order[baked++];
        for (std::size_t axis = 0; axis < 3; ++axis)
          CHECK(at[3 * v + axis] == (weights[0] * at[3 * corner[0] + axis] + weights[1] * at[3 * corner[1] + axis]) +
                                        weights[2] * at[3 * corner[2] + axis]);
      }
    }
    CHECK(baked == vertices);
  }
  // Beyond the last level there is nothing coarser.
  CHECK(same_bits(pose_at(face, pose, 7), pose_at(face, pose, 2)));
  CHECK(same_bits(pose_at(face, pose, INFINITY), pose_at(face, pose, 2)));
}

TEST_CASE("between levels positions are continuous and half way is half way") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> controls = poses_of(model, 4, 6);
  for (std::size_t p = 0; p < 4; ++p) {
    const auto pose = std::span(controls).subspan(p * face.control_count(), face.control_count());
    for (const float whole : {0.0f, 1.0f}) {
      const std::vector<float> here = pose_at(face, pose, whole), there = pose_at(face, pose, whole + 1);
      const double way = distance(here, there);
      REQUIRE(way > 0.05);
      CHECK(distance(pose_at(face, pose, whole + 0x1p-20f), here) < 1e-4);
      CHECK(distance(pose_at(face, pose, whole + 1 - 0x1p-20f), there) < 1e-4);
      std::vector<float> before = here;
      double steps = 0;
      for (int step = 1; step <= 64; ++step) {
        const std::vector<float> now = pose_at(face, pose, whole + float(step) / 64);
        CHECK(distance(now, before) < 0.2 * way);
        steps += distance(now, before);
        before = now;
      }
      CHECK(steps < 3 * way);
    }
  }
}

TEST_CASE("at rest a level lies between the rest positions of its vertices") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> rest = model.schema.rest_pose();
  for (const float lod : {1.0f, 2.0f}) {
    const std::vector<float> at = pose_at(face, rest, lod);
    for (std::uint32_t i = 0; i < model.levels[std::size_t(lod) - 1].vertices; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(at[3 * model.order[i] + axis] == model.rest.points[3 * model.order[i] + axis]);
  }
}

TEST_CASE("the same bits alone and in batches, in every order and format, in used workspaces, and on any thread") {
  const PackedModel model = levelled_model();
  for (const PoseKernels* kernels : runnable_kernels()) {
    const Evaluator face(model, {}, *kernels), scalar(model, {}, scalar_kernels);
    const std::vector<float> controls = poses_of(model, 19, 7);
    std::vector<Workspace> some;
    for (int w = 0; w < 3; ++w) some.emplace_back(face);
    for (const float lod : {0.25f, 1.0f, 2.0f, 1.75f, 0.0f, 1.5f}) {
      std::vector<float> batched(19 * floats), baked(19 * floats);
      for (const VertexOrder order : {VertexOrder::source, VertexOrder::baked}) {
        std::vector<float>& to = order == VertexOrder::source ? batched : baked;
        Batch batch{.poses = 19, .controls = controls, .positions = {to.data(), to.size()}, .order = order};
        batch.masks.lod = lod;
        face.evaluate_batch(batch, some, {3});
      }
      for (std::size_t p = 0; p < 19; ++p) {
        const auto pose = std::span(controls).subspan(p * face.control_count(), face.control_count());
        const std::vector<float> one = pose_at(scalar, pose, lod);
        const std::vector<float> in_batch(batched.begin() + p * floats, batched.begin() + (p + 1) * floats);
        CHECK_MESSAGE(same_bits(in_batch, one), kernels->name << " at " << lod);
        for (std::size_t i = 0; i < vertices; ++i)
          CHECK(std::equal(&one[3 * model.order[i]], &one[3 * model.order[i]] + 3, &baked[p * floats + 3 * i]));
        CHECK(same_bits(pose_at(face, pose, 0, some[0]), pose_at(scalar, pose, 0)));
      }
    }
  }
}

TEST_CASE("the vertices of a level alone are the first in baked order, and nothing else is written") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 8);
  for (const float lod : {0.5f, 1.0f, 1.5f, 2.0f}) {
    const std::size_t own = 3 * std::size_t(face.level_vertices(std::size_t(lod)));
    Workspace workspace(face);
    const std::vector<float> all = pose_at(face, pose, lod, workspace, VertexOrder::baked);
    std::vector<float> positions(floats, 77), normals(floats, 77);
    Batch batch{.poses = 1, .controls = pose, .positions = {positions.data(), own}, .order = VertexOrder::baked};
    batch.masks.lod = lod;
    batch.masks.level_only = true;
    face.evaluate_batch(batch, {&workspace, 1});
    CHECK(std::equal(all.begin(), all.begin() + std::ptrdiff_t(own), positions.begin()));
    CHECK(std::count(positions.begin() + std::ptrdiff_t(own), positions.end(), 77.0f) == std::ptrdiff_t(floats - own));
    batch.normals = {normals.data(), own};
    face.evaluate_batch(batch, {&workspace, 1});
    CHECK(std::equal(all.begin(), all.begin() + std::ptrdiff_t(own), positions.begin()));
    CHECK(std::count(normals.begin() + std::ptrdiff_t(own), normals.end(), 77.0f) == std::ptrdiff_t(floats - own));
    CHECK(std::count(normals.begin(), normals.begin() + std::ptrdiff_t(own), 77.0f) == 0);
    batch.positions.size = own - 1;
    CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, {&workspace, 1}), doctest::Contains("need"), Error);
    batch.positions.size = own;
    batch.order = VertexOrder::source;
    CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, {&workspace, 1}), doctest::Contains("in baked order only"), Error);
  }
}

// Area-weighted normals of a level's polygons, in binary64; of vertices that it does not have, 0.
std::vector<double> level_normals(const DetailLevel& level, const std::vector<float>& points) {
  std::vector<double> sums(points.size());
  const std::uint32_t* corners = level.polygon_corners.data();
  for (const std::uint32_t size : level.polygon_sizes) {
    double area[3] = {};
    for (std::uint32_t k = 0; k < size; ++k)
      for (int a = 0; a < 3; ++a) {
        const float *u = &points[3 * corners[k]], *v = &points[3 * corners[(k + 1) % size]];
        area[a] += double(u[(a + 1) % 3]) * v[(a + 2) % 3] - double(u[(a + 2) % 3]) * v[(a + 1) % 3];
      }
    for (std::uint32_t k = 0; k < size; ++k)
      for (int a = 0; a < 3; ++a) sums[3 * corners[k] + std::size_t(a)] += area[a];
    corners += size;
  }
  for (std::size_t v = 0; v < sums.size(); v += 3) {
    const double length = std::sqrt(sums[v] * sums[v] + sums[v + 1] * sums[v + 1] + sums[v + 2] * sums[v + 2]);
    for (std::size_t a = 0; a < 3 && length > 0; ++a) sums[v + a] /= length;
  }
  return sums;
}

struct Vectors {
  std::vector<float> normals, tangents;
};

// Those of one pose in the source's order; `only`: of the vertices of the level alone, in baked order.
Vectors vectors_at(const Evaluator& face, std::span<const float> pose, float lod, Workspace& workspace,
                   bool only = false) {
  Vectors vectors{std::vector<float>(floats), std::vector<float>(floats)};
  Batch batch{.poses = 1, .controls = pose, .positions = {}};
  batch.normals = {vectors.normals.data(), floats};
  batch.tangents = {vectors.tangents.data(), floats};
  batch.masks.lod = lod;
  batch.masks.level_only = only;
  if (only) batch.order = VertexOrder::baked;
  face.evaluate_batch(batch, {&workspace, 1});
  return vectors;
}

TEST_CASE("normals and tangents of a level are those of its polygons") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> controls = poses_of(model, 5, 9);
  Workspace workspace(face);
  for (std::size_t p = 0; p < 5; ++p)
    for (const float lod : {1.0f, 2.0f, 1.25f, 0.5f, 1.0f}) {
      const auto pose = std::span(controls).subspan(p * face.control_count(), face.control_count());
      const std::vector<float> positions = pose_at(face, pose, lod);
      const auto [normals, tangents] = vectors_at(face, pose, lod, workspace);
      Workspace fresh(face);
      CHECK(same_bits(normals, vectors_at(face, pose, lod, fresh).normals));
      for (std::size_t v = 0; v < vertices; ++v) {
        const float *n = &normals[3 * v], *t = &tangents[3 * v];
        CHECK(std::abs(n[0] * t[0] + n[1] * t[1] + n[2] * t[2]) < 1e-4);
        const double length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        if (length != 0) CHECK(length == doctest::Approx(1).epsilon(1e-5));  // 0: of no polygon
      }
      const std::size_t k = std::size_t(lod);
      if (k == 0 || float(k) != lod) continue;
      const std::vector<double> exact = level_normals(model.levels[k - 1], positions);
      for (std::uint32_t i = 0; i < model.levels[k - 1].vertices; ++i)
        for (std::size_t a = 0; a < 3; ++a)
          CHECK(normals[3 * model.order[i] + a] == doctest::Approx(exact[3 * model.order[i] + a]).epsilon(1e-3));
      // Vertex 4, the first that level 1 does not have, lies half way from vertex 3 to 5.
      double sum[3], length = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        sum[a] = normals[9 + a] + normals[15 + a];
        length += sum[a] * sum[a];
      }
      for (std::size_t a = 0; a < 3; ++a)
        CHECK(normals[12 + a] == doctest::Approx(sum[a] / std::sqrt(length)).epsilon(1e-3));
    }
}

// Vertices whose vectors at two levels of detail are there, as in this model not all are, and just before each of them
// do not point away from each other: no blend of those that do is continuous.
std::vector<std::size_t> alike(const std::vector<float>& fine, const std::vector<float>& coarse,
                               const std::vector<float>& after_fine, const std::vector<float>& before_coarse) {
  const auto product = [](const std::vector<float>& a, const std::vector<float>& b, std::size_t v) {
    return a[3 * v] * b[3 * v] + a[3 * v + 1] * b[3 * v + 1] + a[3 * v + 2] * b[3 * v + 2];
  };
  std::vector<std::size_t> found;
  for (std::size_t v = 0; v < vertices; ++v)
    if (product(fine, fine, v) > 0 && product(coarse, coarse, v) > 0 && product(after_fine, before_coarse, v) > -0.5f)
      found.push_back(v);
  return found;
}

double distance_at(const std::vector<std::size_t>& chosen, const std::vector<float>& a, const std::vector<float>& b) {
  double most = 0;
  for (const std::size_t v : chosen)
    for (std::size_t i = 3 * v; i < 3 * v + 3; ++i) most = std::max(most, std::abs(double(a[i]) - b[i]));
  return most;
}

TEST_CASE("normals and tangents are continuous in the level of detail") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> controls = poses_of(model, 5, 9);
  Workspace workspace(face);
  constexpr float step = 1.0f / 4096;
  for (std::size_t p = 0; p < 5; ++p) {
    const auto pose = std::span(controls).subspan(p * face.control_count(), face.control_count());
    for (int k = 0; k < 2; ++k) {
      const auto at = [&](float lod) { return vectors_at(face, pose, lod, workspace); };
      const Vectors fine = at(float(k)), coarse = at(float(k + 1));
      const Vectors after = at(float(k) + step), close = at(float(k + 1) - step);
      const std::vector<std::size_t> normals = alike(fine.normals, coarse.normals, after.normals, close.normals);
      const std::vector<std::size_t> tangents = alike(fine.tangents, coarse.tangents, after.tangents, close.tangents);
      CHECK(normals.size() >= 20);
      CHECK(tangents.size() >= 20);
      Vectors before = fine;
      for (int parts = 1; parts <= 4096; parts += 63) {
        // At the level first, then by steps in which a blend moves little.
        const Vectors here = at(float(k) + float(parts) * step);
        if (parts == 1) CHECK(distance_at(normals, before.normals, here.normals) < 0.003);
        CHECK(distance_at(normals, before.normals, here.normals) < 0.15);
        CHECK(distance_at(tangents, before.tangents, here.tangents) < 0.3);
        before = here;
      }
      CHECK(distance_at(normals, close.normals, coarse.normals) < 0.003);
    }
  }
}

TEST_CASE("between levels normals are the blend of what both levels' polygons give") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 9);
  Workspace workspace(face);
  DetailLevel whole;
  whole.polygon_sizes = model.rest.polygon_sizes;
  whole.polygon_corners = model.rest.polygon_corners;
  for (const float lod : {0.5f, 1.5f}) {
    const Vectors all = vectors_at(face, pose, lod, workspace), only = vectors_at(face, pose, lod, workspace, true);
    const std::size_t k = std::size_t(lod);
    const std::vector<float> positions = pose_at(face, pose, lod);
    const std::vector<double> fine = level_normals(k == 0 ? whole : model.levels[k - 1], positions);
    const std::vector<double> coarse = level_normals(model.levels[k], positions);
    int checked = 0;
    for (std::uint32_t i = 0; i < face.level_vertices(k); ++i) {
      const std::size_t v = 3 * std::size_t(model.order[i]);
      for (std::size_t a = 0; a < 3; ++a) CHECK(only.normals[3 * i + a] == all.normals[v + a]);
      double blend[3], length = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        blend[a] = fine[v + a] + coarse[v + a];
        length += blend[a] * blend[a];
      }
      if (i >= face.level_vertices(k + 1) || length < 0.01) continue;
      ++checked;
      for (std::size_t a = 0; a < 3; ++a)
        CHECK(all.normals[v + a] == doctest::Approx(blend[a] / std::sqrt(length)).epsilon(1e-3));
    }
    CHECK(checked >= 5);
  }
}

TEST_CASE("meshes, sockets and channels go with levels") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 10);
  const std::vector<std::uint8_t> teeth = {0, 1};
  for (const VertexOrder order : {VertexOrder::source, VertexOrder::baked})
    for (const float lod : {0.5f, 1.0f, 1.5f, 2.0f}) {
      Workspace workspace(face);
      const std::vector<float> all = pose_at(face, pose, lod, workspace, order);
      std::vector<float> positions(floats, 77), frames(24), channels(4);
      Batch batch{.poses = 1, .controls = pose, .positions = {positions.data(), floats}, .order = order};
      batch.masks.lod = lod;
      batch.masks.meshes = teeth;
      face.evaluate_batch(batch, {&workspace, 1});
      for (std::uint32_t i = 0; i < vertices; ++i) {
        const bool posed = (order == VertexOrder::baked ? model.order[i] : i) >= 18;
        for (std::size_t a = 0; a < 3; ++a) CHECK(positions[3 * i + a] == (posed ? all[3 * i + a] : 77.0f));
      }
      batch.masks.meshes = {};
      batch.sockets = {frames.data(), 24};
      face.evaluate_batch(batch, {&workspace, 1});
      CHECK(same_bits(positions, all));
      const std::vector<float> alone = frames;
      batch.channels = {channels.data(), 4};
      face.evaluate_batch(batch, {&workspace, 1});
      CHECK(same_bits(positions, all));
      CHECK(same_bits(frames, alone));
      for (std::size_t c = 0; c < 4; ++c) CHECK(channels[c] >= face.schema().channels[c].minimum);
    }
}

TEST_CASE("bounds and displacements are those of the vertices that are written") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 12);
  for (const bool level_only : {false, true})
    for (const float lod : {0.5f, 1.0f, 2.0f}) {
      Workspace workspace(face);
      const std::vector<float> all = pose_at(face, pose, lod, workspace, VertexOrder::baked);
      const std::size_t own = level_only ? face.level_vertices(std::size_t(lod)) : vertices;
      std::vector<float> bounds(6), moved(floats, 77);
      Batch batch{.poses = 1, .controls = pose, .positions = {moved.data(), 3 * own}, .order = VertexOrder::baked};
      batch.masks.lod = lod;
      batch.masks.level_only = level_only;
      batch.bounds = {bounds.data(), 6};
      batch.displacements = true;
      face.evaluate_batch(batch, {&workspace, 1});
      for (std::size_t a = 0; a < 3; ++a) {
        float low = INFINITY, high = -INFINITY;
        for (std::size_t i = 0; i < own; ++i) {
          const float x = all[3 * i + a];
          low = std::min(low, x);
          high = std::max(high, x);
          CHECK(moved[3 * i + a] == x - model.rest.points[3 * model.order[i] + a]);
        }
        CHECK(bounds[a] == low);
        CHECK(bounds[3 + a] == high);
      }
      CHECK(std::count(moved.begin() + std::ptrdiff_t(3 * own), moved.end(), 77.0f) ==
            std::ptrdiff_t(floats - 3 * own));
    }
}

TEST_CASE("levels that are no numbers or below 0 are refused") {
  const PackedModel model = levelled_model();
  const Evaluator face(model);
  const std::vector<float> pose = poses_of(model, 1, 11);
  CHECK_THROWS_WITH_AS(pose_at(face, pose, NAN), doctest::Contains("not a number"), Error);
  CHECK_THROWS_WITH_AS(pose_at(face, pose, -0.5f), doctest::Contains("below 0"), Error);
  CHECK_THROWS_WITH_AS(pose_at(face, pose, -INFINITY), doctest::Contains("below 0"), Error);
}

}  // namespace

}  // namespace test_detail_levels
