// Exact poses in the runtime: the formula of EVALUATION.md, rest, single poses, batches, meshes and channels.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_exact_poses {

using namespace fb;
using namespace fb::runtime;

namespace {

PackedModel uncorrected() {
  PackedModel model = exact_model();
  model.exact.clear();
  return model;
}

std::vector<float> points_of(const Evaluator& face, const std::vector<float>& pose) {
  Workspace workspace(face);
  std::vector<float> points(3 * face.point_count());
  face.evaluate_points(pose.data(), points.data(), workspace);
  return points;
}

// A pose between two.
std::vector<float> between(const std::vector<float>& from, const std::vector<float>& to, float share) {
  std::vector<float> pose = from;
  for (std::size_t c = 0; c < pose.size(); ++c) pose[c] += share * (to[c] - from[c]);
  return pose;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST_CASE("corrections are whole at their poses and none at rest") {
  const PackedModel model = exact_model();
  const Evaluator face(model), base(uncorrected());
  for (const ExactPose& pose : model.exact) {
    const std::vector<float> points = points_of(face, pose.controls), before = points_of(base, pose.controls);
    for (std::uint32_t row = 0; row < pose.values.size(); ++row) {
      const std::size_t at = model.coordinate(row);
      CHECK(points[at] == before[at] + pose.step * static_cast<float>(pose.values[row]));
    }
  }
  CHECK(same_bits(points_of(face, model.schema.rest_pose()), model.rest.points));
}

TEST_CASE("between poses weights are those of the formula, and add up to 1 at most") {
  PackedModel model = exact_model();
  const RigSchema& schema = model.schema;
  const std::vector<float> pose = between(model.exact[0].controls, schema.rest_pose(), 0.125f);
  const std::vector<float> places = places_in_ranges(schema, pose);
  double distance = 0;
  const std::vector<float> exact_places = places_in_ranges(schema, model.exact[0].controls);
  for (std::size_t c = 0; c < places.size(); ++c) distance += std::pow(double(places[c]) - exact_places[c], 2);
  const double weight = std::pow(1 - distance * model.exact[0].falloff, 2);
  CHECK(weight > 0.1);
  CHECK(weight < 0.99);
  model.exact.resize(1);
  const std::vector<float> before = points_of(Evaluator(uncorrected()), pose);
  std::vector<float> points = points_of(Evaluator(model), pose);
  for (std::uint32_t row = 0; row < points.size(); ++row) {
    const std::size_t at = model.coordinate(row);
    const double correction = double(model.exact[0].step) * model.exact[0].values[row];
    CHECK(points[at] - before[at] == doctest::Approx(weight * correction).epsilon(1e-4));
  }
  // Of three equal poses each has a third where their weights add up to more than 1.
  for (const char* name : {"again", "and again"}) (model.exact.emplace_back(model.exact[0])).name = name;
  points = points_of(Evaluator(model), pose);
  const double share = std::min(1.0, 3 * weight);
  for (std::uint32_t row = 0; row < points.size(); ++row) {
    const std::size_t at = model.coordinate(row);
    const double correction = double(model.exact[0].step) * model.exact[0].values[row];
    CHECK(points[at] - before[at] == doctest::Approx(share * correction).epsilon(1e-4));
  }
}

TEST_CASE("batches of all orders and meshes have the same bits as single poses, whatever was posed before") {
  const PackedModel model = exact_model();
  const Evaluator face(model);
  Workspace workspace(face);
  Random random(5);
  std::vector<std::vector<float>> poses;
  for (const ExactPose& pose : model.exact)
    for (const float share : {0.0f, 0.1f, 1.0f})
      poses.push_back(between(pose.controls, model.schema.rest_pose(), share));
  for (int i = 0; i < 14; ++i)
    poses.push_back(between(model.exact[std::size_t(i % 2)].controls, random_pose(model.schema, random), 0.2f));
  std::vector<float> controls;
  for (const auto& pose : poses) controls.insert(controls.end(), pose.begin(), pose.end());
  const std::size_t width = 3 * face.vertex_count(), count = poses.size();
  std::vector<float> positions(count * width), normals(count * width), channels(count * face.channel_count()),
      teeth(count * width), baked(count * width);
  Batch batch;
  batch.poses = count;
  batch.controls = controls;
  batch.positions = {positions.data(), positions.size()};
  batch.normals = {normals.data(), normals.size()};
  batch.channels = {channels.data(), channels.size()};
  face.evaluate_batch(batch, {&workspace, 1});
  const std::uint8_t meshes[] = {0, 1};
  Batch masked = batch;
  masked.normals = {}, masked.channels = {};
  masked.positions = {teeth.data(), teeth.size()};
  masked.masks.meshes = meshes;
  face.evaluate_batch(masked, {&workspace, 1});
  Batch direct = batch;
  direct.normals = {}, direct.channels = {};
  direct.positions = {baked.data(), baked.size()};
  direct.order = VertexOrder::baked;
  face.evaluate_batch(direct, {&workspace, 1});
  for (std::size_t p = 0; p < count; ++p) {
    const std::vector<float> points = points_of(face, poses[p]);
    const auto first = positions.begin() + std::ptrdiff_t(p * width);
    CHECK(same_bits({first, first + std::ptrdiff_t(width)}, {points.begin(), points.begin() + std::ptrdiff_t(width)}));
    for (std::size_t i = 3 * 18; i < width; ++i) CHECK(teeth[p * width + i] == points[i]);
    for (std::uint32_t row = 0; row < width; ++row) CHECK(baked[p * width + row] == points[model.coordinate(row)]);
    for (std::size_t c = 0; c < face.channel_count(); ++c)
      CHECK(channels[p * face.channel_count() + c] == model.schema.channels[c].value(points[width + c]));
  }
}

TEST_CASE("normals are those of corrected positions") {
  const PackedModel model = exact_model();
  const Evaluator face(model), base(uncorrected());
  const auto normals_of = [&](const Evaluator& of) {
    Workspace workspace(of);
    std::vector<float> normals(3 * of.vertex_count());
    Batch batch;
    batch.poses = 1;
    batch.controls = model.exact[0].controls;
    batch.normals = {normals.data(), normals.size()};
    of.evaluate_batch(batch, {&workspace, 1});
    return normals;
  };
  CHECK(!same_bits(normals_of(face), normals_of(base)));
  // A rigid shift of a mesh leaves its normals alone.
  PackedModel shifted = exact_model();
  std::fill(shifted.exact[0].values.begin(), shifted.exact[0].values.end(), 0);
  for (std::uint32_t row = 0; row < 54; row += 3) shifted.exact[0].values[row] = 1 << 20;
  const std::vector<float> kept = normals_of(base), moved = normals_of(Evaluator(shifted));
  for (std::size_t i = 0; i < kept.size(); ++i) CHECK(moved[i] == doctest::Approx(kept[i]).epsilon(1e-4));
}

}  // namespace

}  // namespace test_exact_poses
