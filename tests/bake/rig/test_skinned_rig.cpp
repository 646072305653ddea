// A rig whose positions have the motion of its joints in them: a bake takes it out, and a host puts it back.
#include <cmath>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "bake/rig/rig_source.h"
#include "bake/rig_process/rig_messages.h"
#include "bake_test_support.h"
#include "runtime/evaluator.h"
#include "skinning.h"
#include "test_models.h"

namespace test_skinned_rig {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

// A sheet of 12 x 9 vertices on two joints. Control "jaw" moves the lower rows, "nod" and "turn" the joints.
struct BodyRig {
  Mesh rest = grid_mesh(12, 9);  // before skinning
  std::vector<fb_rig_control> controls = {
      {"jaw", nullptr, 0, 1, 0, 0}, {"nod", nullptr, -1, 1, 0, 0}, {"turn", nullptr, -1, 1, 0.25f, 0}};
  std::vector<fb_joint> joints;
  std::vector<std::uint16_t> of_vertices;
  std::vector<float> weights, shown;  // shown: at rest, after skinning
  std::vector<fb_channel> channels;
  fb_rig rig;
  Character character;
  bool flat = false;  // the head loses its depth where "nod" is 1

  BodyRig() {
    const float still[12] = {1, 0, 0, 2, 0, 1, 0, 1, 0, 0, 1, 0};
    for (const char* name : {"neck", "head"}) {
      fb_joint joint = {sizeof(fb_joint), joints.empty() ? FB_NO_JOINT : 0, name, {}, {}};
      std::copy_n(still, 12, joint.rest);
      joints.push_back(joint);
      Joint& same = character.joints.emplace_back();
      same.name = name;
      same.parent = joint.parent;
      std::copy_n(still, 12, same.rest.begin());
    }
    // The head was bound as it is at rest, the neck turned by a right angle.
    const float bound[12] = {0, 1, 0, -1, -1, 0, 0, 2, 0, 0, 1, 0.5f};
    std::copy_n(bound, 12, joints[0].inverse_bind);
    std::copy_n(bound, 12, character.joints[0].inverse_bind.begin());
    character.joints[1].inverse_bind = {1, 0, 0, -4, 0, 1, 0, -2, 0, 0, 1, 0};
    for (std::size_t v = 0; v < rest.vertex_count(); ++v) {
      const float share = float(v / 12) / 8;
      of_vertices.insert(of_vertices.end(), {0, 1});
      weights.insert(weights.end(), {share > 0.75f ? 0 : 1 - share, share > 0.75f ? 1 : share});
    }
    character.skin = {2, of_vertices, weights};
    fb_rig_init(&rig);
    rig.name = "body";
    rig.units = "m";
    rig.up_axis = "y";
    rig.flags = FB_RIG_SKINNED | FB_RIG_THREAD_SAFE;
    rig.control_count = 3;
    rig.controls = controls.data();
    rig.vertex_count = static_cast<std::uint32_t>(rest.vertex_count());
    rig.polygon_count = static_cast<std::uint32_t>(rest.polygon_sizes.size());
    rig.polygon_sizes = rest.polygon_sizes.data();
    rig.polygon_corners = rest.polygon_corners.data();
    rig.user = this;
    rig.joint_count = 2;
    rig.joints = joints.data();
    rig.skin_influences = 2;
    rig.skin_joints = of_vertices.data();
    rig.skin_weights = weights.data();
    rig.evaluate_skinned = evaluate;
    const std::vector<double> points = skinned(character, joint_places(character), rest.points);
    shown.assign(points.begin(), points.end());
    rig.rest_positions = shown.data();
  }
  BodyRig(const BodyRig&) = delete;

  std::vector<Place> places(const float* pose) const {
    const double nod = double(pose[1]), turn = double(pose[2]) - 0.25;
    const Place neck = {
        std::cos(nod), std::sin(nod), 0, 0, -std::sin(nod), std::cos(nod), 0, 0, 0, 0, 1, 0, 2 + 3 * nod, 1, nod, 1};
    const double depth = flat ? 1 - double(pose[1]) : 1;
    const Place head = {std::cos(turn), 0, -std::sin(turn) * depth, 0, 0, 1, 0,        0,
                        std::sin(turn), 0, std::cos(turn) * depth,  0, 2, 1, 2 * turn, 1};
    return {neck, times(neck, head)};
  }

  std::vector<float> before_skinning(const float* pose) const {
    std::vector<float> points = rest.points;
    for (std::size_t v = 0; v < 48; ++v) points[3 * v + 1] -= pose[0] * (1 + 0.25f * pose[0]) * float(v % 12) / 12;
    return points;
  }

  static fb_status evaluate(void* user, std::uint64_t poses, const float* controls, float* positions, float* channels,
                            float* joints, char*, std::uint32_t) {
    const auto& self = *static_cast<const BodyRig*>(user);
    for (std::uint64_t p = 0; p < poses; ++p, controls += 3) {
      const std::vector<Place> places = self.places(controls);
      for (const double x : skinned(self.character, places, self.before_skinning(controls)))
        *positions++ = static_cast<float>(x);
      for (const Place& place : places)
        for (std::size_t row = 0; row < 3; ++row)
          for (std::size_t column = 0; column < 4; ++column) *joints++ = static_cast<float>(place[4 * column + row]);
      for (std::size_t c = 0; c < self.channels.size(); ++c) *channels++ = controls[0];
    }
    return FB_OK;
  }
};

std::vector<float> posed(const PackedModel& face, const float* pose) {
  const runtime::Evaluator evaluator(face);
  runtime::Workspace workspace(evaluator);
  std::vector<float> points(3 * evaluator.vertex_count());
  evaluator.evaluate(pose, points.data(), workspace);
  return points;
}

float largest_apart(std::span<const float> a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

void check_refused(const std::function<void(BodyRig&)>& change, const char* message) {
  BodyRig rig;
  change(rig);
  const std::string what = failure(Status::rig, [&] { RigSource(rig.rig); });
  CHECK_MESSAGE(contains(what, message), what);
}

}  // namespace

TEST_CASE("what joints do is taken out of a rig's positions") {
  BodyRig rig;
  RigSource source(rig.rig);
  CHECK(source.character().joints[0] == rig.character.joints[0]);
  CHECK(source.character().joints[1].inverse_bind == rig.character.joints[1].inverse_bind);
  CHECK(source.character().skin.joints[0] == 0);
  CHECK(source.character().skin.weights[0] == 1);
  CHECK(source.version() == RigSource(BodyRig().rig).version());
  BodyRig other;
  other.joints[0].inverse_bind[3] += 1e-6f;
  CHECK(source.version() != RigSource(other.rig).version());
  const float tolerance = 1e-6f * static_cast<float>(source.rest().diagonal());
  CHECK(largest_apart(source.rest().points, rig.rest.points) < tolerance);
  const float poses[] = {1, 0, 0.25f, 0.5f, 1, -1, 0, -0.75f, 1};
  std::vector<float> points(3 * rig.rest.points.size());
  source.evaluate(poses, 3, points);
  for (std::size_t p = 0; p < 3; ++p)
    CHECK(largest_apart(std::span(points).subspan(p * rig.rest.points.size(), rig.rest.points.size()),
                        rig.before_skinning(poses + 3 * p)) < tolerance);
}

TEST_CASE("channels come beside positions whose joints are taken out") {
  BodyRig rig;
  rig.channels = {{sizeof(fb_channel), 0, "wrinkle", "", 0, 1, 0}};
  rig.rig.channels = rig.channels.data();
  rig.rig.channel_count = 1;
  RigSource source(rig.rig);
  const float pose[] = {0.5f, 1, -1};
  std::vector<float> points(source.rest().points.size());
  source.evaluate(pose, 1, points);
  CHECK(source.schema().channels[0].value(points[rig.rest.points.size()]) == doctest::Approx(0.5));
}

TEST_CASE("a rig that says it is skinned and does not say how is refused") {
  check_refused([](BodyRig& r) { r.rig.evaluate_skinned = nullptr; }, "evaluate_skinned is null");
  check_refused([](BodyRig& r) { r.rig.skin_influences = 0; }, "FB_RIG_SKINNED without a skin");
  check_refused([](BodyRig& r) { r.rig.struct_size = offsetof(fb_rig, joint_count); }, "ends before evaluate_skinned");
  check_refused([](BodyRig& r) { r.weights[7] = 3; }, "vertex 3 has weights of joints that sum to");
  check_refused([](BodyRig& r) { std::fill_n(r.joints[1].rest, 4, 0.0f); },
                "joint \"head\" has no inverse bind matrix");
  check_refused([](BodyRig& r) { std::fill_n(r.joints[0].inverse_bind, 4, 0.0f); },
                "at rest: the blend of the joints of vertex 0 cannot be inverted");
  check_refused([](BodyRig& r) { r.rig.rest_positions = r.rest.points.data(); }, "rest");
  check_refused([](BodyRig& r) { r.rig.flags = 0; }, "evaluate is null");
}

TEST_CASE("a pose whose joints cannot be undone is told by its number and vertex") {
  BodyRig rig;
  rig.flat = true;
  RigSource source(rig.rig);
  const float poses[] = {0, 0.5f, 0.5f, 0, 1, 0.5f};
  std::vector<float> points(2 * rig.rest.points.size());
  const std::string what = failure(Status::rig, [&] { source.evaluate(poses, 2, points); });
  CHECK_MESSAGE(contains(what, "pose 1: rig \"body\" failed: the blend of the joints of vertex 84 cannot be inverted"),
                what);
}

TEST_CASE("a baked face of a skinned rig, skinned by its joints, is the rig") {
  BodyRig rig;
  RigSource source(rig.rig);
  const Folder folder;
  BakeOptions options;
  options.recipe = "compact";
  options.poses = 300;
  options.epochs = 30;
  options.work = folder.path();
  const archive::Archive archive = archive::read_archive(bake_face(source, options, silent_progress()).archive);
  CHECK(archive.model.character == source.character());
  const double diagonal = rig.rest.diagonal();
  double worst = 0, moved = 0;
  Random random(5);
  for (int p = 0; p < 40; ++p) {
    const float pose[] = {random.uniform(0, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const std::vector<Place> places = rig.places(pose);
    const std::vector<double> expected = skinned(rig.character, places, rig.before_skinning(pose)),
                              still = skinned(rig.character, joint_places(rig.character), rig.before_skinning(pose)),
                              found = skinned(archive.model.character, places, posed(archive.model, pose));
    for (std::size_t i = 0; i < expected.size(); ++i) {
      worst = std::max(worst, std::abs(found[i] - expected[i]));
      moved = std::max(moved, std::abs(still[i] - expected[i]));
    }
  }
  MESSAGE("joints move vertices by " << moved / diagonal << " D; off by at most " << worst / diagonal << " D");
  CHECK(moved > 0.25 * diagonal);
  CHECK(worst < 2e-3 * diagonal);
}

TEST_CASE("joints and skin go through the rig protocol and datasets") {
  BodyRig rig;
  RigSource source(rig.rig);
  const RigDescription description = description_of(hello_answer(source));
  CHECK(description.character == source.character());
  CHECK(description.rest.points == source.rest().points);
  const Folder folder;
  sample(source, {.poses = 20}, folder.path(), {}, silent_progress());
  const auto recorded = open_source(folder.path());
  CHECK(recorded->character() == source.character());
  CHECK(recorded->rest().points == source.rest().points);
}

}  // namespace test_skinned_rig
