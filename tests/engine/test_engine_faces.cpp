#include <doctest/doctest.h>
#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "UnrealFace.h"
#include "counted_new.h"
#include "engine_fixtures.h"
#include "face_pose.h"
#include "linear_skin.h"
#include "render_surfaces.h"
#include "shared_archives.h"

namespace {

using facebaker::Model;
using facebaker::engine::Axes;
using facebaker::engine::FacePose;
using facebaker::engine::LinearSkin;
using facebaker::engine::PosedFrame;
using facebaker::engine::RenderSurface;
using facebaker::unreal::UnrealFace;

// Frames of the driven joints of a pose.
std::vector<float> driven_joint_frames(const Model& model, const std::vector<float>& controls) {
  std::vector<float> frames(12 * std::size_t(fb_driven_joint_count(model.get())));
  if (frames.empty()) return frames;
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = controls.data();
  batch.control_floats = controls.size();
  batch.joints = frames.data();
  batch.joint_floats = frames.size();
  facebaker::Scratch(model).evaluate(batch);
  return frames;
}

TEST_CASE("poses have the bits of fb_evaluate") {
  for (const char* name : {"tiny", "character", "body", "exact", "levels", "driven"}) {
    const Model model = fixture(name);
    FacePose pose(model);
    const std::size_t count = 3 * std::size_t(model.vertex_count());
    CHECK(std::equal(model.rest_positions(), model.rest_positions() + count, pose.current()->positions.begin()));
    const std::vector<float> controls = widest(model);
    REQUIRE(pose.set_controls(controls.data(), controls.size()));
    CHECK(pose.pose());
    facebaker::Scratch scratch(model);
    std::vector<float> expected(count);
    scratch.evaluate(controls.data(), expected.data());
    CHECK(pose.current()->positions == expected);
    CHECK(pose.current()->number == 2);
    CHECK(pose.current()->driven_joints == driven_joint_frames(model, controls));
    CHECK_FALSE(pose.set_controls(controls.data(), controls.size() - 1));
    CHECK_FALSE(pose.set_control(model.control_count(), 0));
  }
}

TEST_CASE("frames that are held do not change, and others are used again") {
  const Model model = fixture("tiny");
  FacePose pose(model);
  const std::shared_ptr<const PosedFrame> held = pose.current();
  const std::vector<float> kept = held->positions;
  std::set<const PosedFrame*> frames;
  for (int i = 1; i < 100; ++i) {
    pose.set_control(0, model.control(0).maximum * float(i) / 100);
    REQUIRE(pose.pose());
    REQUIRE(pose.previous() != pose.current());
    frames.insert(pose.current().get());
  }
  CHECK(held->positions == kept);
  CHECK(frames.size() <= 3);
  const auto last = pose.current();
  CHECK_FALSE(pose.pose());
  CHECK(pose.previous() == last);
}

TEST_CASE("posing allocates nothing once it runs") {
  const Model model = fixture("body");
  std::string error;
  const auto face = UnrealFace::make(model, error);
  REQUIRE(face);
  const std::array<float, 12> motion = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0};
  const auto frame = [&](int i) {
    face->pose().set_control(0, model.control(0).maximum * float(i % 7) / 7);
    face->set_joint_motion(0, motion.data());
    return face->update(error) == UnrealFace::Update::changed;
  };
  bool all = true;
  for (int i = 0; i < 4; ++i) all = frame(i) && all;
  const long before = allocation_count();
  REQUIRE(before > 0);
  for (int i = 4; i < 100; ++i) all = frame(i) && all;
  CHECK(allocation_count() == before);
  CHECK(all);
}

TEST_CASE("poses of a model share its working memory, for each thread") {
  const Model model = fixture("levels");
  std::vector<std::unique_ptr<FacePose>> poses;
  for (int i = 0; i < 20; ++i) poses.push_back(std::make_unique<FacePose>(model));
  const auto shared = facebaker::engine::SharedScratches::of(model);
  CHECK(shared == facebaker::engine::SharedScratches::of(model));
  CHECK(shared->scratch_count() == 1);
  CHECK(shared != facebaker::engine::SharedScratches::of(fixture("levels")));
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int round = 1; round <= 50; ++round)
        for (std::size_t i = t; i < poses.size(); i += 4) {
          poses[i]->set_control(0, model.control(0).maximum * float(round) / 50);
          poses[i]->pose();
        }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(shared->scratch_count() <= 4);
  for (const auto& pose : poses) CHECK(pose->current()->positions == poses[0]->current()->positions);
  poses[0]->set_control(0, std::numeric_limits<float>::quiet_NaN());
  CHECK_THROWS_AS(poses[0]->pose(), facebaker::Error);
  CHECK(poses[1]->set_control(0, 0));
  CHECK(poses[1]->pose());
  CHECK(shared->scratch_count() <= 4);
}

TEST_CASE("an archive of the same bytes is loaded once while it is held") {
  const auto read = [](const std::string& name) {
    std::ifstream file(FB_FIXTURES "/" + name + ".fbk", std::ios::binary);
    return std::vector<char>(std::istreambuf_iterator<char>(file), {});
  };
  using facebaker::engine::load_shared;
  const std::vector<char> bytes = read("tiny"), copy = bytes, other = read("levels");
  auto first = load_shared(bytes.data(), bytes.size());
  CHECK(load_shared(copy.data(), copy.size()) == first);
  CHECK(load_shared(other.data(), other.size()) != first);
  CHECK(load_shared(copy.data(), copy.size()) == first);
  std::vector<char> broken = bytes;
  broken[broken.size() / 2] ^= 1;
  for (int i = 0; i < 2; ++i) CHECK_THROWS_AS(load_shared(broken.data(), broken.size()), facebaker::Error);
  const std::weak_ptr<const facebaker::engine::SharedArchive> before = first;
  first.reset();
  CHECK(before.expired());
  CHECK(load_shared(bytes.data(), bytes.size())->model.vertex_count() == 30);
}

TEST_CASE("NaN is an error, and frames stay") {
  const Model model = fixture("tiny");
  FacePose pose(model);
  const auto before = pose.current();
  pose.set_control(1, std::numeric_limits<float>::quiet_NaN());
  for (int i = 0; i < 2; ++i) CHECK_THROWS_AS(pose.pose(), facebaker::Error);
  CHECK(pose.current() == before);
  pose.set_control(1, model.control(1).maximum);
  CHECK(pose.pose());
}

TEST_CASE("another thread reads frames while the next are made") {
  const Model model = fixture("character");
  FacePose pose(model);
  std::mutex mutex;  // of what is shown, not of what it holds
  std::shared_ptr<const PosedFrame> shown;
  const auto show = [&](std::shared_ptr<const PosedFrame> frame) {
    const std::lock_guard lock(mutex);
    shown = std::move(frame);
  };
  std::atomic<bool> done{false};
  std::atomic<int> torn{0}, read{0};
  // Poses are at one of two values of a control; a frame that is written while it is read would be neither.
  std::map<float, std::vector<float>> valid;
  for (const float value : {0.25f, 0.5f}) {
    pose.set_control(0, value);
    pose.pose();
    valid[value] = pose.current()->positions;
  }
  show(pose.current());
  std::thread reader([&] {
    while (!done) {
      std::unique_lock lock(mutex);
      const auto frame = shown;
      lock.unlock();
      if (frame->positions != valid[0.25f] && frame->positions != valid[0.5f]) ++torn;
      if (frame->number < 2) ++torn;
      ++read;
    }
  });
  for (int i = 0; i < 2000 || read < 100; ++i) {
    pose.set_control(0, i % 2 == 0 ? 0.25f : 0.5f);
    pose.pose();
    show(pose.current());
  }
  done = true;
  reader.join();
  CHECK(torn == 0);
}

// A triangle of the engine faces where its normal says: the cross product of the first edge and the second, or for an
// engine that has it the other way round, of the second and the first.
void check_facing(const Model& model, const Axes& axes, bool second_first) {
  const FacePose pose(model);
  for (const RenderSurface& surface : facebaker::engine::render_surfaces(model, axes)) {
    double along = 0;
    const std::vector<std::uint32_t>& indices = surface.levels[0].indices;
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      std::array<std::array<float, 3>, 3> at;
      std::array<float, 3> normal;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t from = 3 * std::size_t(surface.sources[indices[i + k]]);
        axes.convert_position(pose.current()->positions.data() + from, at[k].data());
        axes.convert_direction(pose.current()->normals.data() + from, normal.data());
      }
      std::array<float, 3> a, b;
      for (std::size_t k = 0; k < 3; ++k) a[k] = at[1][k] - at[0][k], b[k] = at[2][k] - at[0][k];
      if (second_first) std::swap(a, b);
      along += double((a[1] * b[2] - a[2] * b[1]) * normal[0] + (a[2] * b[0] - a[0] * b[2]) * normal[1] +
                      (a[0] * b[1] - a[1] * b[0]) * normal[2]);
    }
    CHECK(along > 0);
  }
}

TEST_CASE("triangles face as engines expect") {
  const Model model = fixture("tiny");
  check_facing(model, Axes(), false);
  for (const char* up_axis : {"y", "z"}) {
    check_facing(model, facebaker::engine::axes_of_unreal(up_axis, "cm"), true);
    check_facing(model, facebaker::engine::axes_of_godot(up_axis, "cm", true), true);  // clockwise in right-handed axes
  }
}

TEST_CASE("up is up in the engine's unit, and handedness is the engine's") {
  for (const char* up_axis : {"y", "z"}) {
    const bool z_up = up_axis == std::string("z");
    const float up[3] = {0, z_up ? 0.f : 1.f, z_up ? 1.f : 0.f};
    const Axes godot = facebaker::engine::axes_of_godot(up_axis, "cm", true);
    const Axes unreal = facebaker::engine::axes_of_unreal(up_axis, "m");
    float to[3];
    godot.convert_position(up, to);
    CHECK(to[0] == 0);
    CHECK(to[1] == 0.01f);
    CHECK(to[2] == 0);
    unreal.convert_position(up, to);
    CHECK(to[0] == 0);
    CHECK(to[1] == 0);
    CHECK(to[2] == 100);
    for (const Axes* axes : {&godot, &unreal}) {
      float x[3], y[3], z[3];
      const float unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
      axes->convert_direction(unit, x);
      axes->convert_direction(unit + 3, y);
      axes->convert_direction(unit + 6, z);
      const float determinant =
          x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
      CHECK(determinant == (axes == &godot ? 1.f : -1.f));
    }
  }
  CHECK(facebaker::engine::axes_of_godot("y", "cm", false).scale == 1);
  CHECK(facebaker::engine::metres_per("furlong") == 1);
}

TEST_CASE("motions are taken back to the archive's axes") {
  const Model model = fixture("body");
  const Axes axes = facebaker::engine::axes_of_unreal("y", "cm");
  const std::array<float, 12> motion = {0, -1, 0, 3, 1, 0, 0, -4, 0, 0, 1, 5};
  std::array<float, 12> back;
  axes.convert_motion_back(motion.data(), back.data());
  const std::array<float, 3> point = {1, 2, 3};
  std::array<float, 3> moved, expected, shown, found;
  for (std::size_t row = 0; row < 3; ++row)
    moved[row] =
        back[4 * row] * point[0] + back[4 * row + 1] * point[1] + back[4 * row + 2] * point[2] + back[4 * row + 3];
  axes.convert_position(moved.data(), found.data());
  axes.convert_position(point.data(), shown.data());
  for (std::size_t row = 0; row < 3; ++row)
    expected[row] = motion[4 * row] * shown[0] + motion[4 * row + 1] * shown[1] + motion[4 * row + 2] * shown[2] +
                    motion[4 * row + 3];
  for (std::size_t k = 0; k < 3; ++k) CHECK(found[k] == doctest::Approx(expected[k]));
}

// Where the skin takes a vertex with all joints at rest, in doubles: this face's joints are not at rest where it was
// bound.
std::array<double, 3> skinned_at_rest(const Model& model, const std::vector<float>& positions, std::size_t vertex) {
  const std::uint32_t influences = fb_skin_influences(model.get());
  std::array<double, 3> sum{};
  if (fb_skin_weights(model.get())[vertex * influences] <= 0) {  // of a mesh that follows no joint
    for (std::size_t k = 0; k < 3; ++k) sum[k] = double(positions[3 * vertex + k]);
    return sum;
  }
  for (std::size_t i = vertex * influences; i < (vertex + 1) * influences; ++i) {
    std::array<double, 3> point;
    for (std::size_t k = 0; k < 3; ++k) point[k] = double(positions[3 * vertex + k]);
    fb_joint joint;
    fb_joint_init(&joint);
    std::uint32_t index = fb_skin_joints(model.get())[i];
    const auto apply = [&point](const float* frame) {
      std::array<double, 3> to;
      for (std::size_t row = 0; row < 3; ++row)
        to[row] = double(frame[4 * row]) * point[0] + double(frame[4 * row + 1]) * point[1] +
                  double(frame[4 * row + 2]) * point[2] + double(frame[4 * row + 3]);
      point = to;
    };
    REQUIRE(fb_joint_at(model.get(), index, &joint) == FB_OK);
    apply(joint.inverse_bind);
    for (; index != FB_NO_JOINT; index = joint.parent) {
      REQUIRE(fb_joint_at(model.get(), index, &joint) == FB_OK);
      apply(joint.rest);
    }
    for (std::size_t k = 0; k < 3; ++k) sum[k] += double(fb_skin_weights(model.get())[i]) * point[k];
  }
  return sum;
}

TEST_CASE("frames are converted as positions are") {
  const Model model = fixture("character");
  const FacePose pose(model);
  REQUIRE(pose.current()->sockets.size() == 12 * std::size_t(fb_socket_count(model.get())));
  REQUIRE_FALSE(pose.current()->sockets.empty());
  for (const Axes& axes :
       {facebaker::engine::axes_of_unreal("y", "cm"), facebaker::engine::axes_of_unreal("z", "m"),
        facebaker::engine::axes_of_godot("y", "cm", true), facebaker::engine::axes_of_godot("z", "mm", true)}) {
    std::array<float, 12> to, back;
    axes.convert_frame(pose.current()->sockets.data(), to.data());
    axes.convert_motion_back(to.data(), back.data());
    for (std::size_t i = 0; i < 12; ++i) CHECK(back[i] == doctest::Approx(pose.current()->sockets[i]));
    const float origin[3] = {pose.current()->sockets[3], pose.current()->sockets[7], pose.current()->sockets[11]};
    float converted[3];
    axes.convert_position(origin, converted);
    for (std::size_t k = 0; k < 3; ++k) CHECK(to[4 * k + 3] == converted[k]);
  }
}

// How much of what follows a driven joint follows a joint of the host.
double part_of(const Model& model, std::uint32_t driven_joint, std::uint32_t joint) {
  const std::size_t driven = fb_driven_influences(model.get()), influences = fb_skin_influences(model.get());
  double part = 0, all = 0;
  for (std::size_t v = 0; v < model.vertex_count(); ++v)
    for (std::size_t i = v * driven; i < (v + 1) * driven; ++i)
      for (std::size_t k = v * influences; k < (v + 1) * influences; ++k) {
        if (fb_driven_skin_joints(model.get())[i] != driven_joint) continue;
        const double weight = double(fb_driven_skin_weights(model.get())[i]) * double(fb_skin_weights(model.get())[k]);
        all += weight;
        part += fb_skin_joints(model.get())[k] == joint ? weight : 0;
      }
  return all > 0 ? part / all : 0;
}

// A pose is taken where the joints of the host are at rest, and moves with these.
void check_skin(const Model& model, const PosedFrame& pose) {
  LinearSkin skin(model);
  REQUIRE(skin.joint_count() > 1);
  std::vector<float> positions, normals, tangents;
  skin.apply(pose, positions, normals, tangents);
  for (std::size_t v = 0; v < model.vertex_count(); ++v) {
    const std::array<double, 3> expected = skinned_at_rest(model, pose.positions, v);
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(double(positions[3 * v + k]) == doctest::Approx(expected[k]).epsilon(1e-4));
  }
  const std::array<float, 12> shift = {1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 1, 30};
  REQUIRE(skin.set_motion(0, shift.data()));
  CHECK_FALSE(skin.set_motion(std::uint32_t(skin.joint_count()), shift.data()));
  std::vector<float> moved;
  skin.apply(pose, moved, normals, tangents);
  const std::uint32_t influences = fb_skin_influences(model.get());
  for (std::size_t v = 0; v < model.vertex_count(); ++v) {
    float weight = 0;  // of joint 0
    for (std::uint32_t i = 0; i < influences; ++i)
      if (fb_skin_joints(model.get())[v * influences + i] == 0)
        weight += fb_skin_weights(model.get())[v * influences + i];
    CHECK(moved[3 * v + 1] - positions[3 * v + 1] == doctest::Approx(20 * weight).epsilon(1e-3));
  }
}

TEST_CASE("a skin takes vertices where its joints are, and moves them with these") {
  for (const char* name : {"body", "driven"}) {
    const Model model = fixture(name);
    FacePose pose(model);
    const std::vector<float> controls = widest(model);
    REQUIRE(pose.set_controls(controls.data(), controls.size()));
    REQUIRE(pose.pose());
    check_skin(model, *pose.current());
  }
}

TEST_CASE("the frame of a driven joint is moved as what follows the joint") {
  const Model model = fixture("driven");
  FacePose pose(model);
  const std::vector<float> controls = widest(model);
  REQUIRE(pose.set_controls(controls.data(), controls.size()));
  REQUIRE(pose.pose());
  const std::vector<float>& frames = pose.current()->driven_joints;
  LinearSkin skin(model);
  std::array<float, 12> before, after;
  // Joints that all move alike take the frame along.
  const std::array<float, 12> motion = {0, -1, 0, 3, 1, 0, 0, -4, 0, 0, 1, 5};
  skin.move_frame(3, frames.data() + 36, before.data());
  for (std::uint32_t i = 0; i < skin.joint_count(); ++i) skin.set_motion(i, motion.data());
  skin.move_frame(3, frames.data() + 36, after.data());
  for (std::size_t column = 0; column < 4; ++column) {
    CHECK(after[column] == doctest::Approx(-before[4 + column] + (column == 3 ? 3 : 0)));
    CHECK(after[4 + column] == doctest::Approx(before[column] - (column == 3 ? 4 : 0)));
    CHECK(after[8 + column] == doctest::Approx(before[8 + column] + (column == 3 ? 5 : 0)));
  }
  // A joint that moves alone moves it by its part of what follows the driven joint.
  LinearSkin still(model), moved(model);
  const std::array<float, 12> shift = {1, 0, 0, 0, 0, 1, 0, 20, 0, 0, 1, 0};
  REQUIRE(moved.set_motion(0, shift.data()));
  const auto path = [&](std::uint32_t joint) {
    still.move_frame(joint, frames.data() + 12 * joint, before.data());
    moved.move_frame(joint, frames.data() + 12 * joint, after.data());
    return double(after[7] - before[7]);
  };
  for (const std::uint32_t joint : {1u, 3u}) CHECK(path(joint) == doctest::Approx(20 * part_of(model, joint, 0)));
  CHECK(part_of(model, 1, 0) > 0.01);
  CHECK(part_of(model, 1, 0) < 0.99);
  CHECK(part_of(model, 0, 0) == 0);  // no vertex follows the jaw: it is moved as the tongue, and the pin as the jaw
  CHECK(path(0) == doctest::Approx(path(1)));
  CHECK(path(2) == doctest::Approx(path(1)));
  LinearSkin(fixture("character")).move_frame(0, frames.data(), after.data());  // without joints nothing moves
  CHECK(std::equal(after.begin(), after.end(), frames.begin()));
}

TEST_CASE("Unreal's face fills buffers with motion, and stops") {
  std::string error;
  CHECK_FALSE(facebaker::unreal::load_archive(nullptr, 0, error));
  CHECK_FALSE(error.empty());
  const Model model = fixture("character");
  const auto face = UnrealFace::make(model, error);
  REQUIRE(face);
  CHECK(face->update(error) == UnrealFace::Update::unchanged);
  const std::vector<float> before = face->buffers(0).positions;
  CHECK(face->find_control(model.control(0).name, error) == 0);
  CHECK(face->find_control("no such control", error) == -1);
  face->pose().set_control(0, model.control(0).maximum);
  REQUIRE(face->update(error) == UnrealFace::Update::changed);
  const auto& buffers = face->buffers(0);
  for (std::size_t i = 0; i < before.size(); ++i)
    CHECK(buffers.motion[i] == doctest::Approx(before[i] - buffers.positions[i]));
  CHECK(std::any_of(buffers.motion.begin(), buffers.motion.end(), [](float m) { return m != 0; }));
  REQUIRE(face->update(error) == UnrealFace::Update::changed);
  CHECK(std::all_of(buffers.motion.begin(), buffers.motion.end(), [](float m) { return m == 0; }));
  CHECK(face->update(error) == UnrealFace::Update::unchanged);
  face->pose().set_control(0, std::numeric_limits<float>::quiet_NaN());
  CHECK(face->update(error) == UnrealFace::Update::failed);
  CHECK(error.find(model.control(0).name) != std::string::npos);
}

}  // namespace
