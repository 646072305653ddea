// Outputs of an evaluator other than positions in source order: normals, tangents, large batches, host threads.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <thread>

#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_evaluator_outputs {

using namespace fb;
using namespace fb::runtime;

namespace {

struct Posed {
  std::vector<float> positions, normals, tangents;  // tangents of faces that have texture coordinates
};

std::vector<Workspace> workspaces(const Evaluator& evaluator, int count) {
  std::vector<Workspace> made;
  for (int w = 0; w < count; ++w) made.emplace_back(evaluator);
  return made;
}

Posed evaluate(const Evaluator& evaluator, const std::vector<float>& controls, std::vector<Workspace>& workspaces,
               const Parallel& parallel = {1}) {
  const std::size_t poses = controls.size() / evaluator.control_count(), floats = poses * 3 * evaluator.vertex_count();
  Posed posed{std::vector<float>(floats), std::vector<float>(floats), {}};
  Batch batch{.poses = poses, .controls = controls, .positions = {}};
  batch.positions = {posed.positions.data(), floats};
  batch.normals = {posed.normals.data(), floats};
  if (!evaluator.tangent_signs().empty()) {
    posed.tangents.resize(floats);
    batch.tangents = {posed.tangents.data(), floats};
  }
  evaluator.evaluate_batch(batch, workspaces, parallel);
  return posed;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// Normalised sums of the polygons' area vectors, from the closed loops of their corners.
std::vector<double> polygon_normals(const Mesh& mesh, const std::vector<float>& points) {
  std::vector<double> sums(points.size());
  const std::uint32_t* corners = mesh.polygon_corners.data();
  for (const std::uint32_t size : mesh.polygon_sizes) {
    double area[3] = {};
    for (std::uint32_t k = 0; k < size; ++k)
      for (int a = 0; a < 3; ++a) {
        const float *u = points.data() + 3 * corners[k], *v = points.data() + 3 * corners[(k + 1) % size];
        area[a] += double(u[(a + 1) % 3]) * v[(a + 2) % 3] - double(u[(a + 2) % 3]) * v[(a + 1) % 3];
      }
    for (std::uint32_t k = 0; k < size; ++k)
      for (int a = 0; a < 3; ++a) sums[3 * corners[k] + a] += area[a];
    corners += size;
  }
  for (std::size_t v = 0; v < sums.size(); v += 3) {
    const double length = std::sqrt(sums[v] * sums[v] + sums[v + 1] * sums[v + 1] + sums[v + 2] * sums[v + 2]);
    for (int a = 0; a < 3; ++a) sums[v + a] = length > 0 ? sums[v + a] / length : 0;
  }
  return sums;
}

// Every control moves its own band of rows, so that one control leaves most of the face at rest.
PackedModel banded_model() {
  PackedModel model = tiny_packed_model();
  Random random(5);
  model.schema.controls.clear();
  model.features.clear();
  model.regions.clear();
  model.direct.clear();
  model.row_blocks.clear();
  model.order.clear();
  model.rest = grid_mesh(40, 30);
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  for (std::uint32_t first = 0; first < rows; first += 100) {
    const auto c = static_cast<std::uint32_t>(model.direct.size());
    model.schema.controls.push_back({"band" + std::to_string(c), 0, 1, 0, ""});
    model.features.push_back({Feature::Kind::identity, c});
    model.direct.push_back(c);
    model.row_blocks.push_back(random_row_block(random, first, std::min(100u, rows - first), {c}, 2));
  }
  model.columns = static_cast<std::uint32_t>(model.direct.size());
  return model;
}

// Six polygons around a vertex instead of four.
PackedModel triangulated(PackedModel model) {
  const Mesh quads = model.rest;
  model.rest.polygon_sizes.assign(2 * quads.polygon_sizes.size(), 3);
  model.rest.polygon_corners.clear();
  for (std::size_t q = 0; q < quads.polygon_corners.size(); q += 4)
    for (const std::size_t k : {0, 1, 2, 0, 2, 3}) model.rest.polygon_corners.push_back(quads.polygon_corners[q + k]);
  return model;
}

std::vector<float> sparse_pose(const PackedModel& model, Random& random, float share) {
  std::vector<float> pose = model.schema.rest_pose();
  const std::vector<float> other = random_pose(model.schema, random);
  for (std::size_t c = 0; c < pose.size(); ++c)
    if (random.uniform() < share) pose[c] = other[c];
  return pose;
}

// The sums of (e1 dv2 - e2 dv1) over the triangles of the polygons' fans, orthogonalised against the normals.
std::vector<double> fan_tangents(const Mesh& mesh, const Posed& posed) {
  std::vector<double> sums(posed.positions.size());
  std::size_t first = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    double area = 0, sum[3] = {};
    for (std::uint32_t k = 1; k + 1 < size; ++k) {
      const std::size_t corner[3] = {first, first + k, first + k + 1};
      const auto uv = [&](int i, int axis) { return double(mesh.uvs[2 * mesh.uv_corners[corner[i]] + axis]); };
      const auto at = [&](int i, int a) { return double(posed.positions[3 * mesh.polygon_corners[corner[i]] + a]); };
      const double du1 = uv(1, 0) - uv(0, 0), dv1 = uv(1, 1) - uv(0, 1), du2 = uv(2, 0) - uv(0, 0),
                   dv2 = uv(2, 1) - uv(0, 1);
      area += du1 * dv2 - du2 * dv1;
      for (int a = 0; a < 3; ++a) sum[a] += (at(1, a) - at(0, a)) * dv2 - (at(2, a) - at(0, a)) * dv1;
    }
    for (std::uint32_t k = 0; k < size; ++k)
      for (int a = 0; a < 3; ++a) sums[3 * mesh.polygon_corners[first + k] + a] += area < 0 ? -sum[a] : sum[a];
    first += size;
  }
  for (std::size_t v = 0; v < sums.size(); v += 3) {
    double along = 0, squares = 0;
    for (int a = 0; a < 3; ++a) along += sums[v + a] * posed.normals[v + a];
    for (int a = 0; a < 3; ++a) sums[v + a] -= along * posed.normals[v + a], squares += sums[v + a] * sums[v + a];
    for (int a = 0; a < 3; ++a) sums[v + a] /= std::sqrt(squares);
  }
  return sums;
}

// Poses evaluated in one workspace: member `of` has the same bits as with a new workspace, and differs from `expected`
// by less than `tolerance`.
template <class Expected>
void check_poses(const PackedModel& model, std::vector<float> Posed::*of, double tolerance, const Expected& expected) {
  const Evaluator evaluator(model);
  std::vector<Workspace> kept = workspaces(evaluator, 1);
  Random random(2);
  for (const float share : {1.0f, 0.1f, 0.0f, 0.05f, 0.05f, 0.5f}) {
    const std::vector<float> pose = sparse_pose(model, random, share);
    const Posed posed = evaluate(evaluator, pose, kept);
    std::vector<Workspace> fresh = workspaces(evaluator, 1);
    CHECK(same_bits(posed.*of, evaluate(evaluator, pose, fresh).*of));
    const std::vector<double> wanted = expected(posed);
    double worst = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
      worst = std::max(worst, std::fabs(wanted[i] - double((posed.*of)[i])));
    CHECK(worst < tolerance);
  }
}

}  // namespace

TEST_CASE("tangents follow the texture on the posed mesh, independent of earlier poses") {
  for (PackedModel model : {tiny_packed_model(), banded_model(), triangulated(banded_model())}) {
    give_uvs(model.rest);
    check_poses(model, &Posed::tangents, 1e-4, [&](const Posed& posed) { return fan_tangents(model.rest, posed); });
  }
}

TEST_CASE("a mirrored texture changes the sign and not the tangent; without area there is no tangent") {
  PackedModel model = banded_model();
  give_uvs_by_vertex(model.rest);
  const std::vector<float> rest = model.schema.rest_pose();
  std::vector<std::vector<float>> found;
  for (const float factor : {1.0f, -1.0f, 0.0f}) {
    PackedModel turned = model;
    for (std::size_t i = 1; i < turned.rest.uvs.size(); i += 2) turned.rest.uvs[i] *= factor;
    const Evaluator evaluator(turned);
    CHECK(std::all_of(evaluator.tangent_signs().begin(), evaluator.tangent_signs().end(),
                      [&](float s) { return s == (factor < 0 ? -1 : 1); }));
    std::vector<Workspace> work = workspaces(evaluator, 1);
    found.push_back(evaluate(evaluator, rest, work).tangents);
  }
  CHECK(same_bits(found[0], found[1]));
  CHECK(std::all_of(found[2].begin(), found[2].end(), [](float t) { return t == 0; }));
}

TEST_CASE("tangents of a face without texture coordinates are refused") {
  const PackedModel model = tiny_packed_model();
  const Evaluator evaluator(model);
  CHECK(evaluator.tangent_signs().empty());
  std::vector<Workspace> work = workspaces(evaluator, 1);
  std::vector<float> tangents(90);
  const std::vector<float> rest = model.schema.rest_pose();
  Batch batch{.poses = 1, .controls = rest, .positions = {}};
  batch.tangents = {tangents.data(), tangents.size()};
  CHECK_THROWS_WITH(evaluator.evaluate_batch(batch, work), "a face without texture coordinates has no tangents");
}

TEST_CASE("normals are those of the posed mesh, independent of earlier poses") {
  for (const PackedModel& model : {tiny_packed_model(), banded_model(), triangulated(banded_model())})
    check_poses(model, &Posed::normals, 1e-5,
                [&](const Posed& posed) { return polygon_normals(model.rest, posed.positions); });
}

TEST_CASE("faces of any size have the same normals and tangents") {
  PackedModel ordinary = triangulated(banded_model());
  give_uvs(ordinary.rest);
  Random random(3);
  const std::vector<float> pose = random_pose(ordinary.schema, random);
  const auto posed_at = [&](int exponent) {
    PackedModel model = ordinary;
    for (float& value : model.rest.points) value = std::ldexp(value, exponent);
    for (PackedRowBlock& block : model.row_blocks)
      for (PackedColumn& column : block.columns) column.scale = std::ldexp(column.scale, exponent);
    const Evaluator evaluator(model);
    std::vector<Workspace> work = workspaces(evaluator, 1);
    return evaluate(evaluator, pose, work);
  };
  const Posed expected = posed_at(0);
  for (const int exponent : {-89, -40, -20, 20, 40, 77}) {  // a diagonal of 50 becomes about 1e-25 to 1e25
    CAPTURE(exponent);
    const Posed posed = posed_at(exponent);
    CHECK(same_bits(posed.normals, expected.normals));
    CHECK(same_bits(posed.tangents, expected.tangents));
  }
}

TEST_CASE("a mesh without polygons has null normals") {
  PackedModel model = tiny_packed_model();
  model.rest.polygon_sizes.clear();
  model.rest.polygon_corners.clear();
  const Evaluator evaluator(model);
  std::vector<Workspace> kept = workspaces(evaluator, 1);
  Random random(2);
  const Posed posed = evaluate(evaluator, random_pose(model.schema, random), kept);
  CHECK(std::all_of(posed.normals.begin(), posed.normals.end(), [](float n) { return n == 0; }));
}

TEST_CASE("row blocks return to rest in the next pose") {
  const PackedModel model = banded_model();
  const Evaluator evaluator(model);
  Workspace workspace(evaluator);
  Random random(3);
  std::vector<float> positions(model.rest.points.size() / 3 * 4);
  for (int n = 0; n < 6; ++n) {
    const std::vector<float> pose = sparse_pose(model, random, n % 2 ? 0.0f : 0.5f);
    evaluator.evaluate(pose.data(), positions.data(), workspace, 4);
    Workspace fresh(evaluator);
    std::vector<float> expected(positions.size());
    evaluator.evaluate(pose.data(), expected.data(), fresh, 4);
    CHECK(same_bits(positions, expected));
  }
}

TEST_CASE("large batches, written with non-temporal stores, have the same bits at any address") {
  for (const PackedModel& model : {banded_model(), tiny_packed_model()}) {
    const Evaluator evaluator(model);
    const std::size_t poses = (std::size_t(5) << 20) / (3 * sizeof(float) * evaluator.vertex_count());
    Random random(8);
    std::vector<float> controls;
    for (std::size_t p = 0; p < poses; ++p) {
      const std::vector<float> pose = sparse_pose(model, random, 0.3f);
      controls.insert(controls.end(), pose.begin(), pose.end());
    }
    std::vector<Workspace> some = workspaces(evaluator, 2);
    const std::size_t floats = poses * 3 * evaluator.vertex_count();
    for (const VertexOrder order : {VertexOrder::source, VertexOrder::baked})
      for (const std::size_t offset : {0u, 1u, 3u}) {
        std::vector<float> positions(floats + offset + 1, 77.0f), expected = positions;
        Batch batch{.poses = poses, .controls = controls, .positions = {}};
        batch.positions = {positions.data() + offset, floats};
        batch.order = order;
        evaluator.evaluate_batch(batch, some, {2});
        for (std::size_t p = 0; p < poses; ++p) {
          batch.poses = 1;
          batch.controls = std::span(controls).subspan(p * evaluator.control_count(), evaluator.control_count());
          batch.positions = {expected.data() + offset + p * 3 * evaluator.vertex_count(), 3 * evaluator.vertex_count()};
          evaluator.evaluate_batch(batch, some, {1});
        }
        CHECK(same_bits(positions, expected));
      }
  }
}

TEST_CASE("a batch on the host's threads has the same bits") {
  const PackedModel model = banded_model();
  const Evaluator evaluator(model);
  Random random(12);
  std::vector<float> controls;
  for (int p = 0; p < 50; ++p) {
    const std::vector<float> pose = sparse_pose(model, random, 0.5f);
    controls.insert(controls.end(), pose.begin(), pose.end());
  }
  std::vector<Workspace> one = workspaces(evaluator, 1), some = workspaces(evaluator, 4);
  const Posed expected = evaluate(evaluator, controls, one);
  const auto host = [](void*, std::uint32_t count, std::uint32_t workers, HostTask task, void* context) {
    std::atomic<std::uint32_t> next = 0;
    std::vector<std::thread> crew;
    for (std::uint32_t worker = 0; worker < workers; ++worker)
      crew.emplace_back([&, worker] {
        for (std::uint32_t i; (i = next++) < count;) task(context, i, worker);
      });
    for (std::thread& thread : crew) thread.join();
  };
  for (int n = 0; n < 5; ++n) {
    const Posed posed = evaluate(evaluator, controls, some, {4, host, nullptr});
    CHECK(same_bits(posed.positions, expected.positions));
    CHECK(same_bits(posed.normals, expected.normals));
  }
}

TEST_CASE("every instruction set gives the same bits") {
  for (const PackedModel& model : {tiny_packed_model(), banded_model()}) {
    Random random(9);
    std::vector<float> controls;
    for (int p = 0; p < 8; ++p) {
      const std::vector<float> pose = sparse_pose(model, random, 0.2f * float(p));
      controls.insert(controls.end(), pose.begin(), pose.end());
    }
    Posed expected;
    for (const PoseKernels* kernels : runnable_kernels()) {
      const Evaluator evaluator(model, {}, *kernels);
      std::vector<Workspace> some = workspaces(evaluator, 1);
      const Posed posed = evaluate(evaluator, controls, some);
      if (kernels == &scalar_kernels) expected = posed;
      CHECK_MESSAGE(same_bits(posed.positions, expected.positions), kernels->name);
      CHECK_MESSAGE(same_bits(posed.normals, expected.normals), kernels->name);
    }
  }
}

}  // namespace test_evaluator_outputs
