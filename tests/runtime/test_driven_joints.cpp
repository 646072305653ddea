// Driven joints in the runtime: the formulas of EVALUATION.md against a reference in double precision, rest, kernels,
// batches, levels, meshes, and what a host is given to skin by itself.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "joint_reference.h"
#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_driven_joints {

using namespace fb;
using namespace fb::runtime;

namespace {

using Numbers = std::vector<float>;
using Pose = std::vector<float>;

bool same_bits(const Numbers& a, const Numbers& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

Numbers points_of(const Evaluator& face, const Pose& pose, Workspace& workspace, bool unskinned = false) {
  Numbers points(3 * face.point_count());
  face.evaluate_points(pose.data(), points.data(), workspace, unskinned);
  return points;
}

Numbers points_of(const Evaluator& face, const Pose& pose, bool unskinned = false) {
  Workspace workspace(face);
  return points_of(face, pose, workspace, unskinned);
}

// With vertices that follow joints in one order, so that eight of them are moved together.
PackedModel grouped_model() {
  PackedModel model = gentle_model();
  Skin& skin = model.rest.driven.skin;
  for (std::size_t i = 0; i < skin.joints.size(); ++i) skin.joints[i] = i % 3 == 2 ? 3 : i % 3;
  return model;
}

void check_skinning(const PackedModel& model) {
  const Evaluator face(model);
  Random random(5);
  double furthest = 0;
  for (int pose = 0; pose < 40; ++pose) {
    const Pose controls = random_pose(model.schema, random);
    const Numbers unskinned = points_of(face, controls, true), posed = points_of(face, controls);
    const std::vector<double> expected = reference_positions(model.rest, unskinned);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(posed[i] == doctest::Approx(expected[i]).epsilon(1e-5).scale(4));
      furthest = std::max(furthest, std::fabs(double(posed[i]) - unskinned[i]));
    }
    // What carries numbers is as it was.
    CHECK(same_bits({posed.begin() + std::ptrdiff_t(expected.size()), posed.end()},
                    {unskinned.begin() + std::ptrdiff_t(expected.size()), unskinned.end()}));
    Numbers frames(12 * face.joint_count());
    Workspace workspace(face);
    Batch batch;
    batch.poses = 1;
    batch.controls = controls;
    batch.joints = {frames.data(), frames.size()};
    face.evaluate_batch(batch, {&workspace, 1});
    const std::vector<Frame<double>> reference = reference_frames(model.rest, unskinned);
    for (std::size_t i = 0; i < frames.size(); ++i)
      CHECK(frames[i] == doctest::Approx(reference[i / 12][i % 12]).epsilon(1e-5).scale(2));
  }
  CHECK(furthest > 0.5);
}

}  // namespace

TEST_CASE("positions and frames are those of linear blend skinning") {
  check_skinning(gentle_model());
  check_skinning(grouped_model());
  PackedModel twice = grouped_model();
  for (std::uint16_t& joint : twice.rest.driven.skin.joints)
    if (joint == 1) joint = 0;
  check_skinning(twice);
}

TEST_CASE("a joint that overflows moves only the vertices that follow it") {
  PackedModel model = grouped_model();
  const Evaluator usual(model);
  for (std::size_t n = model.rest.driven.scales.size() - 12; n < model.rest.driven.scales.size(); ++n)
    model.rest.driven.scales[n] = 3e38f;  // of the last joint, 3
  const Evaluator overflowing(model);
  Random random(7);
  const Pose controls = random_pose(model.schema, random);
  const Numbers expected = points_of(usual, controls), found = points_of(overflowing, controls);
  const Skin& skin = model.rest.driven.skin;
  std::size_t others = 0, different = 0;
  for (std::size_t v = 0; v < model.rest.surface_vertex_count(); ++v) {
    const bool same = std::memcmp(&expected[3 * v], &found[3 * v], 3 * sizeof(float)) == 0;
    if (skin.count(v) == skin.influences) {
      different += !same;
      continue;
    }
    CHECK(same);
    ++others;
  }
  CHECK(others > 20);
  CHECK(different > 0);
}

TEST_CASE("at rest nothing moves, not even the sign of a zero") {
  PackedModel model = whole_model();
  model.rest.points[7] = -0.0f;
  const Evaluator face(model);
  Workspace workspace(face);
  Random random(3);
  points_of(face, random_pose(model.schema, random), workspace);
  CHECK(same_bits(points_of(face, model.schema.rest_pose(), workspace), model.rest.points));
  Numbers frames(12 * face.joint_count());
  Batch batch;
  batch.poses = 1;
  const Pose rest = model.schema.rest_pose();
  batch.controls = rest;
  batch.joints = {frames.data(), frames.size()};
  face.evaluate_batch(batch, {&workspace, 1});
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK(frames[i] == model.rest.driven.joints[i / 12].rest[i % 12]);
}

TEST_CASE("kernels, batches, workspaces that were used, levels and meshes give the same bits") {
  const PackedModel model = whole_model();
  const std::size_t vertices = model.rest.surface_vertex_count(), poses = 2 * poses_per_block + 3;
  Random random(8);
  Numbers controls;
  for (std::size_t p = 0; p < poses; ++p)
    for (const float value : random_pose(model.schema, random)) controls.push_back(value);
  for (const float lod : {0.0f, 0.5f, 1.0f, 1.25f, 2.0f}) {
    Numbers first;
    for (const PoseKernels* kernels : runnable_kernels()) {
      const Evaluator face(model, {}, *kernels);
      std::vector<Workspace> workspaces;
      workspaces.emplace_back(face);
      Numbers together(poses * 3 * vertices), normals(together.size()), frames(poses * 12 * face.joint_count());
      Batch batch;
      batch.poses = poses;
      batch.controls = controls;
      batch.positions = {together.data(), together.size()};
      batch.normals = {normals.data(), normals.size()};
      batch.joints = {frames.data(), frames.size()};
      batch.masks.lod = lod;
      face.evaluate_batch(batch, workspaces);
      together.insert(together.end(), normals.begin(), normals.end());
      together.insert(together.end(), frames.begin(), frames.end());
      if (first.empty()) first = together;
      CHECK_MESSAGE(same_bits(first, together), kernels->name);
      // Pose by pose, one mesh at a time, in a workspace that has posed others.
      for (std::size_t p = 0; p < poses; ++p) {
        Numbers alone(3 * vertices);
        batch.poses = 1;
        batch.controls = std::span(controls).subspan(p * face.control_count(), face.control_count());
        batch.positions = {alone.data(), alone.size()};
        batch.normals = batch.tangents = {};
        batch.joints = {};
        for (const std::vector<std::uint8_t>& mask : {std::vector<std::uint8_t>{1, 0}, {0, 1}}) {
          batch.masks.meshes = mask;
          face.evaluate_batch(batch, workspaces);
        }
        batch.masks.meshes = {};
        const auto from = first.begin() + std::ptrdiff_t(p * 3 * vertices);
        CHECK(same_bits(alone, {from, from + std::ptrdiff_t(3 * vertices)}));
      }
    }
  }
}

TEST_CASE("displacements are those before joints, and come with frames that skin them") {
  const PackedModel model = gentle_model();
  const Evaluator face(model);
  Workspace workspace(face);
  Random random(11);
  const Pose controls = random_pose(model.schema, random);
  const std::size_t size = 3 * face.vertex_count();
  Numbers displacements(size), bounds(6), frames(12 * face.joint_count());
  Batch batch;
  batch.poses = 1;
  batch.controls = controls;
  batch.positions = {displacements.data(), size};
  batch.displacements = true;
  batch.bounds = {bounds.data(), 6};
  batch.joints = {frames.data(), frames.size()};
  face.evaluate_batch(batch, {&workspace, 1});
  const Numbers unskinned = points_of(face, controls, true), posed = points_of(face, controls);
  for (std::size_t i = 0; i < size; ++i)
    CHECK(displacements[i] == doctest::Approx(unskinned[i] - model.rest.points[i]).epsilon(1e-6));
  // Bounds are those of what is shown.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float least = posed[axis], largest = posed[axis];
    for (std::size_t i = axis; i < size; i += 3)
      least = std::min(least, posed[i]), largest = std::max(largest, posed[i]);
    CHECK(bounds[axis] == least);
    CHECK(bounds[3 + axis] == largest);
  }
}

TEST_CASE("joints have output only where there are some") {
  const Evaluator face(character_model());
  Workspace workspace(face);
  const Pose rest = face.schema().rest_pose();
  Numbers frames(12);
  Batch batch;
  batch.poses = 1;
  batch.controls = rest;
  batch.joints = {frames.data(), 12};
  CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, {&workspace, 1}), doctest::Contains("no driven joints"), Error);
}

}  // namespace test_driven_joints
