// A rig that says of its joints which the controls move: a bake learns those as joints, and leaves the others to a
// host.
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/compare.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/character_json.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/jointless_source.h"
#include "bake/rig/json_field.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/rig/rig_source.h"
#include "bake/rig_process/rig_messages.h"
#include "bake/sampling/drawn_clips.h"
#include "bake_test_support.h"
#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_driven_rig {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

Frame<double> turned(double x, double y, double z, const std::array<double, 3>& at) {
  const double a = std::sqrt(x * x + y * y + z * z), s = a > 0 ? std::sin(a) / a : 1,
               c = a > 0 ? (1 - std::cos(a)) / (a * a) : 0.5;
  return {1 - c * (y * y + z * z), c * x * y - s * z,       c * x * z + s * y,       at[0],
          c * x * y + s * z,       1 - c * (x * x + z * z), c * y * z - s * x,       at[1],
          c * x * z - s * y,       c * y * z + s * x,       1 - c * (x * x + y * y), at[2]};
}

// A sheet of 12 x 9 vertices. A host's neck carries it, on which hangs a jaw, on that a tongue, and on that a tip
// without motion of its own. "open" and "shift" turn the jaw about axes that do not commute, "roll" and "out" turn,
// move and stretch the tongue, "nod" turns the neck, and "puff" moves vertices before all joints.
struct FaceRig {
  Mesh rest = grid_mesh(12, 9);
  std::vector<fb_rig_control> controls;
  std::vector<fb_joint> joints;
  std::vector<std::uint32_t> numbers = {0, FB_JOINT_ROTATE, FB_JOINT_ROTATE | FB_JOINT_MOVE_Z | FB_JOINT_SCALE_Z, 0};
  std::vector<std::uint16_t> of_vertices;
  std::vector<float> weights;
  fb_rig rig;
  Frame<double> axes;  // of the jaw, in those that the others have

  explicit FaceRig(const Frame<double>& of_jaw = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}) : axes(of_jaw) {
    for (const char* name : {"open", "shift", "roll", "out", "nod", "puff"})
      controls.push_back({name, nullptr, -1, 1, 0, 0});
    std::vector<Frame<double>> still = frames(rest_pose().data());
    still[1] = product(still[1], axes);
    for (std::uint32_t j = 0; j < 4; ++j) {
      static constexpr const char* names[] = {"neck", "jaw", "tongue", "tip"};
      fb_joint joint = {sizeof(fb_joint), j == 0 ? FB_NO_JOINT : j - 1, names[j], {}, {}};
      const auto back = j == 0 ? std::nullopt : inverse(still[j - 1]);
      const Frame<float> here = to_float(back ? product(*back, still[j]) : still[j]),
                         bind = to_float(*inverse(still[j]));
      std::copy(here.begin(), here.end(), joint.rest);
      std::copy(bind.begin(), bind.end(), joint.inverse_bind);
      joints.push_back(joint);
    }
    for (std::size_t v = 0; v < rest.vertex_count(); ++v) {
      const std::size_t row = v / 12;  // the rows follow the joints from the neck to the tip, two at a time
      const auto joint = static_cast<std::uint16_t>(std::min<std::size_t>(row / 2, 3));
      of_vertices.insert(of_vertices.end(), {joint, static_cast<std::uint16_t>(std::min(joint + 1, 3))});
      weights.insert(weights.end(),
                     {row % 2 == 0 || joint == 3 ? 1.0f : 0.625f, row % 2 == 0 || joint == 3 ? 0 : 0.375f});
    }
    fb_rig_init(&rig);
    rig.name = "face";
    rig.units = "m";
    rig.up_axis = "y";
    rig.flags = FB_RIG_SKINNED | FB_RIG_THREAD_SAFE;
    rig.control_count = static_cast<std::uint32_t>(controls.size());
    rig.controls = controls.data();
    rig.vertex_count = static_cast<std::uint32_t>(rest.vertex_count());
    rig.polygon_count = static_cast<std::uint32_t>(rest.polygon_sizes.size());
    rig.polygon_sizes = rest.polygon_sizes.data();
    rig.polygon_corners = rest.polygon_corners.data();
    rig.rest_positions = rest.points.data();
    rig.user = this;
    rig.joint_count = 4;
    rig.joints = joints.data();
    rig.joint_numbers = numbers.data();
    rig.skin_influences = 2;
    rig.skin_joints = of_vertices.data();
    rig.skin_weights = weights.data();
    rig.evaluate_skinned = evaluate;
  }
  FaceRig(const FaceRig&) = delete;

  static std::vector<float> rest_pose() { return std::vector<float>(6); }

  static std::vector<Frame<double>> frames(const float* pose) {
    const double open = 0.5 * double(pose[0]), shift = 0.4 * double(pose[1]), roll = 0.75 * double(pose[2]),
                 out = double(pose[3]);
    std::vector<Frame<double>> all = {turned(0, 0, 0.5 * double(pose[4]), {6, -1, 0})};
    all.push_back(product(all[0], product(turned(open, 0, 0, {0, 2, 0.5}), turned(0, shift, 0, {0, 0, 0}))));
    Frame<double> tongue = turned(roll, 0.2 * roll, 0, {0, 2, 0.25 * out});
    for (const std::size_t row : {2, 6, 10}) tongue[row] *= 1 + 0.25 * out;
    all.push_back(product(all[1], tongue));
    all.push_back(product(all[2], turned(0, 0, 0, {0, 2, 0})));
    return all;
  }

  // Before joints.
  std::vector<float> displaced(const float* pose) const {
    std::vector<float> points = rest.points;
    for (std::size_t v = 24; v < 60; ++v) points[3 * v + 2] += 0.5f * pose[5] * float(v % 12) / 12;
    return points;
  }

  static fb_status evaluate(void* user, std::uint64_t poses, const float* controls, float* positions, float*,
                            float* out, char*, std::uint32_t) {
    const auto& self = *static_cast<const FaceRig*>(user);
    const std::vector<Frame<double>> still = frames(rest_pose().data());
    for (std::uint64_t p = 0; p < poses; ++p, controls += 6) {
      const std::vector<Frame<double>> here = frames(controls);
      const std::vector<float> points = self.displaced(controls);
      for (std::size_t v = 0; v < points.size() / 3; ++v)
        for (std::size_t a = 0; a < 3; ++a) {
          double sum = (1 - double(self.weights[2 * v]) - double(self.weights[2 * v + 1])) * double(points[3 * v + a]);
          for (std::size_t i = 2 * v; i < 2 * v + 2; ++i) {
            const Frame<double> m = product(here[self.of_vertices[i]], *inverse(still[self.of_vertices[i]]));
            const double* const row = &m[4 * a];
            sum += self.weights[i] *
                   (row[0] * points[3 * v] + row[1] * points[3 * v + 1] + row[2] * points[3 * v + 2] + row[3]);
          }
          *positions++ = static_cast<float>(sum);
        }
      for (std::size_t j = 0; j < 4; ++j)
        for (const double value : j == 1 ? product(here[1], self.axes) : here[j]) *out++ = static_cast<float>(value);
    }
    return FB_OK;
  }
};

std::vector<float> points_of(Source& source, const std::vector<float>& pose) {
  std::vector<float> points(source.rest().points.size());
  source.evaluate(pose, 1, points);
  return points;
}

std::vector<float> surface_of(Source& source, const std::vector<float>& pose) {
  std::vector<float> points = points_of(source, pose);
  points.resize(source.rest().surface_points().size());
  return points;
}

float largest_apart(std::span<const float> a, std::span<const float> b) {
  REQUIRE(a.size() == b.size());
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

Baked bake_of(Source& source, const Folder& folder, const char* joints) {
  BakeOptions options;
  options.recipe = "compact";
  options.poses = 300;
  options.epochs = 20;
  options.driven_joints = joints;
  options.work = folder.path();
  return bake_face(source, options, silent_progress());
}

// Largest distance of a baked face from the rig, over the diagonal, in some poses in which no host moves.
double worst_of(const PackedModel& model, Source& source) {
  const runtime::Evaluator face(model);
  runtime::Workspace workspace(face);
  Random random(21);
  double worst = 0;
  for (int p = 0; p < 40; ++p) {
    const std::vector<float> pose = random_pose(source.schema(), random);
    std::vector<float> posed(3 * face.vertex_count());
    face.evaluate(pose.data(), posed.data(), workspace);
    worst = std::max(worst, double(largest_apart(posed, surface_of(source, pose))));
  }
  return worst / model.rest.diagonal();
}

}  // namespace

TEST_CASE("joints that controls drive become the face's own, and the host keeps the others") {
  FaceRig rig;
  RigSource source(rig.rig);
  const DrivenJoints& driven = source.rest().driven;
  REQUIRE(driven.joints.size() == 3);
  CHECK(driven.joints[0].name == "jaw");
  CHECK(driven.joints[0].parent == no_joint);
  CHECK(driven.joints[1].parent == 0);
  CHECK(driven.joints[2].numbers == 0);
  CHECK(driven.number_count() == 8);
  REQUIRE(source.character().joints.size() == 1);
  CHECK(source.character().joints[0].name == "neck");
  CHECK(source.character().skin.count(100) == 1);
  CHECK(source.rest().carrier_vertices == 3);

  // What is left of a pose: positions without the neck, and numbers that say the angles.
  const std::vector<float> pose = {0.5f, 0, 1, -1, 1, 0.75f}, no_nod = {0.5f, 0, 1, -1, 0, 0.75f};
  const std::vector<float> points = points_of(source, pose);
  const float tolerance = 2e-6f * static_cast<float>(source.rest().diagonal());
  const std::size_t surface = source.rest().surface_points().size();
  CHECK(largest_apart(std::span(points).first(surface), surface_of(source, no_nod)) < tolerance);
  std::vector<float> positions(surface), numbers(carried_count(source.schema(), source.rest()));
  split_carried(source.schema(), source.rest(), points, 1, positions, numbers);
  const float expected[] = {0.25f, 0, 0, 0.75f, 0.15f, 0, -0.25f, -0.25f};
  for (std::size_t n = 0; n < 8; ++n) CHECK(numbers[n] == doctest::Approx(expected[n]).epsilon(1e-5).scale(1));

  std::vector<float> before = points;
  remove_driven_skin(source.rest(), before);
  CHECK(largest_apart(std::span(before).first(surface), rig.displaced(pose.data())) < tolerance);

  // Displacements of some vertices, of the surface and of those that carry numbers, are those among all.
  const std::vector<std::uint32_t> some = {1, 2, 90, static_cast<std::uint32_t>(source.rest().vertex_count() - 1)};
  std::vector<float> all = points, of_some = points;
  points_to_displacements(source.rest(), all);
  points_to_displacements(source.rest(), of_some, some);
  for (std::size_t i = 0; i < 3 * some.size(); ++i) CHECK(of_some[i] == all[3 * some[i / 3] + i % 3]);
}

TEST_CASE("axes that are mirrored, of other lengths or not orthogonal are straightened") {
  const std::vector<float> pose = {0.5f, -1, 1, -1, 1, 0.75f};
  FaceRig plain, odd({0, -2, 0, 0, 2, 0.1, 0, 0, 0, 0, -0.5, 0});
  RigSource source(plain.rig), other(odd.rig);
  const std::vector<float> points = points_of(source, pose), same = points_of(other, pose);
  const float tolerance = 3e-6f * static_cast<float>(source.rest().diagonal());
  CHECK(largest_apart(surface_of(source, pose), surface_of(other, pose)) < tolerance);
  std::vector<float> before = points, before_too = same;
  remove_driven_skin(source.rest(), before);
  remove_driven_skin(other.rest(), before_too);
  const std::size_t surface = source.rest().surface_points().size();
  CHECK(largest_apart(std::span(before_too).first(surface), std::span(before).first(surface)) < tolerance);
  // A dataset that says so of its own frames is refused.
  Mesh rest = source.rest();
  rest.driven.joints[1].rest[0] = 2;
  CHECK(contains(failure(Status::bad_data, [&] { add_joint_vertices(rest); }), "\"tongue\" has axes that are not"));
}

TEST_CASE("numbers of joints go through the rig protocol and datasets") {
  FaceRig rig;
  RigSource source(rig.rig);
  const RigDescription description = description_of(hello_answer(source));
  CHECK(description.rest.driven == source.rest().driven);
  CHECK(description.rest.points == source.rest().points);
  const std::vector<float> points = points_of(source, {0.5f, -1, 1, -1, 1, 0.75f});
  std::vector<float> answered(points.size());
  CHECK(!read_answer(points_answer(source, points, 1), description, 1, answered));
  const float tolerance = 1e-6f * static_cast<float>(source.rest().diagonal());
  CHECK(largest_apart(answered, points) < tolerance);

  const Folder folder;
  sample(source, {.poses = 20}, folder.path(), {}, silent_progress());
  const auto recorded = open_source(folder.path());
  CHECK(recorded->rest().driven == source.rest().driven);
  const Clip& clip = recorded->clips().back();
  std::vector<float> frame(points.size());
  recorded->read(recorded->clips().size() - 1, clip.frames - 1, 1, frame);
  const auto controls = frames_of(clip, clip.frames - 1, 1, 6);
  CHECK(largest_apart(frame, points_of(source, {controls.begin(), controls.end()})) < tolerance);
}

TEST_CASE("outer rotations and pivots go through JSON, and what they are not is told") {
  const DrivenJoints driven = driven_model().rest.driven;
  nlohmann::ordered_json written;
  write_driven_joints(driven.joints, written);
  const nlohmann::json text = nlohmann::json::parse(written.dump());
  CHECK(read_driven_joints(JsonField(text, "text:")) == driven.joints);
  const auto refused = [&](const char* key, const char* value, const char* message) {
    nlohmann::json changed = text;
    changed["driven_joints"][3][key] = nlohmann::json::parse(value);
    const std::string what = failure(Status::bad_data, [&] { read_driven_joints(JsonField(changed, "text:")); });
    CHECK_MESSAGE(contains(what, message), what);
  };
  refused("numbers", R"(["turn"])", "\"turn\" is none of rotate_x, move_x, scale_x, pivot_x and those of y and z");
  refused("outer_rotations", R"([["rotate_x", "move_y"]])", "\"move_y\" is none of rotate_x and those of y and z");
  refused("outer_rotations", R"([["rotate_x"], []])", "driven_joints[3] outer_rotations[1] is empty");
}

namespace {

// What a child says that serves a FaceRig, whose poses come after skinning.
struct SkinnedChild {
  FaceRig rig;
  nlohmann::ordered_json fields;

  SkinnedChild() {
    fields = {{"type", "hello"}, {"version", 1}, {"name", "face"}, {"units", "m"}, {"up_axis", "y"}, {"skinned", true}};
    for (const fb_rig_control& control : rig.controls)
      fields["controls"].push_back({{"name", control.name}, {"min", -1}, {"max", 1}, {"default", 0}});
    fields["vertices"] = rig.rest.vertex_count();
    fields["polygons"] = rig.rest.polygon_sizes.size();
    fields["skin_influences"] = 2;
    fields["rig_version"] = "3";
    const std::vector<std::vector<const char*>> numbers = {
        {}, {"rotate_x", "rotate_y", "rotate_z"}, {"rotate_x", "rotate_y", "rotate_z", "move_z", "scale_z"}, {}};
    for (std::size_t j = 0; j < 4; ++j) {
      nlohmann::ordered_json joint = {{"name", rig.joints[j].name}, {"rest", rig.joints[j].rest}};
      if (j > 0) joint["parent"] = j - 1;
      if (!numbers[j].empty()) joint["numbers"] = numbers[j];
      fields["joints"].push_back(joint);
    }
  }

  RigMessage hello() const {
    RigMessage message{fields.dump(), {}};
    append<float>(message, rig.rest.points);
    append<std::uint32_t>(message, rig.rest.polygon_sizes);
    append<std::uint32_t>(message, rig.rest.polygon_corners);
    append<std::uint16_t>(message, rig.of_vertices);
    append<float>(message, rig.weights);
    return message;
  }

  RigMessage points(const std::vector<float>& poses, const std::function<void(std::vector<float>&)>& change = {}) {
    const std::size_t count = poses.size() / 6;
    std::vector<float> positions(count * rig.rest.points.size()), frames(count * 4 * 12);
    FaceRig::evaluate(&rig, count, poses.data(), positions.data(), nullptr, frames.data(), nullptr, 0);
    if (change) change(frames);
    RigMessage message{"{\"type\": \"points\", \"poses\": " + std::to_string(count) + "}", {}};
    append<float>(message, positions);
    append<float>(message, frames);
    return message;
  }

  template <class T>
  static void append(RigMessage& message, std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    message.data.insert(message.data.end(), bytes.begin(), bytes.end());
  }
};

}  // namespace

TEST_CASE("a child may give poses after skinning, with frames of joints") {
  SkinnedChild child;
  RigSource source(child.rig.rig);
  const RigDescription description = description_of(child.hello());
  CHECK(description.rest.driven == source.rest().driven);
  CHECK(description.rest.points == source.rest().points);
  CHECK(description.character.joints.size() == 1);
  CHECK(description.version.starts_with("3 (skin "));
  CHECK(answer_floats(description) == 3 * 108 + 4 * 12);
  const std::vector<float> poses = {0.5f, -1, 1, -1, 1, 0.75f, 0, 0, 0.25f, 0, 0, 1};
  std::vector<float> points(2 * source.rest().points.size()), answered = points;
  source.evaluate(poses, 2, points);
  CHECK(!read_answer(child.points(poses), description, 2, answered));
  CHECK(answered == points);
  // A pose whose joints cannot be taken out is one that fails.
  const auto failed = read_answer(child.points(poses, [](std::vector<float>& f) { std::fill_n(&f[60], 12, 0.0f); }),
                                  description, 2, answered);
  REQUIRE(failed);
  CHECK(failed->pose == 1);
  CHECK_MESSAGE(contains(failed->reason, "\"jaw\" is mirrored or flat"), failed->reason);
  RigMessage cut = child.points(poses);
  cut.data.resize(cut.data.size() - 48);
  CHECK(
      contains(failure(Status::rig, [&] { read_answer(cut, description, 2, answered); }), "poses in 2976 bytes were"));
}

TEST_CASE("what a child says wrongly of its joints is refused") {
  const auto refused = [](const std::function<void(SkinnedChild&)>& change, const char* message) {
    SkinnedChild child;
    change(child);
    const std::string what = failure(Status::rig, [&] { description_of(child.hello()); });
    CHECK_MESSAGE(contains(what, message), what);
  };
  refused([](SkinnedChild& c) { c.fields["skinned"] = false; }, "joints has numbers without \"skinned\"");
  refused([](SkinnedChild& c) { c.fields["joints"][1]["numbers"][0] = "turn"; }, "\"turn\" is none of rotate_x");
  refused([](SkinnedChild& c) { c.fields["joints"][1]["numbers"][0] = "pivot_x"; },
          "\"pivot_x\" is none of rotate_x, move_x, scale_x and those of y and z");
  refused([](SkinnedChild& c) { c.fields["skinned"] = 1; }, "skinned");
  refused(
      [](SkinnedChild& c) {
        c.fields["driven_joints"] = {{{"name", "lid"}, {"numbers", {"move_x"}}, {"frame", c.rig.joints[0].rest}}};
      },
      "\"skinned\"");
  refused([](SkinnedChild& c) { c.rig.weights[0] = 0.5f; }, "weights of joints that sum to 0.5, not 1");
  refused([](SkinnedChild& c) { c.rig.of_vertices[0] = 4; }, "vertex 0 follows joint 4 of 4");
}

TEST_CASE("where controls move all joints, vertices may stay partly where they are") {
  FaceRig rig;
  rig.numbers[0] = FB_JOINT_ROTATE;
  rig.weights[0] = 0.5f;
  RigSource source(rig.rig);
  CHECK(source.character().joints.empty());
  CHECK(source.character().skin.influences == 0);
  CHECK(source.rest().driven.joints.size() == 4);
  CHECK(source.rest().driven.skin.weights[0] == 0.5f);
  rig.weights[0] = 1.5f;
  CHECK(contains(failure(Status::rig, [&] { RigSource(rig.rig); }), "weights of joints that sum to 1.5, more than 1"));
}

TEST_CASE("a rig budget holds while joints are composed, too") {
  FaceRig rig;
  RigSource source(rig.rig);
  for (const std::uint64_t budget : {300u, 1100u}) {  // 60 a control are the least to compose joints by
    const Folder work;
    BakeOptions options;
    options.recipe = "compact";
    options.rig_budget = budget;
    options.epochs = 1;
    options.work = work.path();
    const Baked baked = bake_face(source, options, silent_progress());
    CHECK(baked.asked <= budget);
    const archive::Archive face = archive::read_archive(baked.archive);
    CHECK(face.model.rest.driven.joints[0].outer_rotations.size() == (budget < 360 ? 0 : 1));
  }
}

TEST_CASE("a face with driven joints is nearer to its rig than one that learns what they do") {
  FaceRig rig;
  RigSource source(rig.rig);
  const Folder with, without;
  const std::vector<std::byte> kept = bake_of(source, with, "keep").archive,
                               none = bake_of(source, without, "none").archive;
  verify_archive(kept);
  const archive::Archive face = archive::read_archive(kept), plain = archive::read_archive(none);
  const DrivenJoints &driven_joints = face.model.rest.driven, &declared = source.rest().driven;
  CHECK(driven_joints.skin == declared.skin);
  REQUIRE(driven_joints.joints.size() == declared.joints.size());
  for (std::size_t j = 0; j < declared.joints.size(); ++j) {
    DrivenJoint joint = driven_joints.joints[j];
    CHECK(joint.outer_rotations.size() == (joint.name == "jaw" ? 1 : 0));  // "open" after "shift"
    joint.outer_rotations.clear();
    CHECK(joint == declared.joints[j]);
  }
  CHECK(face.format_version == 2001);
  CHECK(plain.model.rest.driven.empty());
  CHECK(plain.format_version == 2000);
  const double driven = worst_of(face.model, source), displaced = worst_of(plain.model, source);
  MESSAGE("worst vertex with driven joints " << driven << " D, without " << displaced << " D");
  CHECK(driven < 1e-3);
  CHECK(driven < 0.2 * displaced);
  // Either is measured against a source with such joints, and one without.
  DrawnClips drawn(std::make_unique<RigSource>(rig.rig), 1, 60),
      drawn_jointless(std::make_unique<JointlessSource>(source), 1, 60);
  for (const PackedModel* model : {&face.model, &plain.model}) {
    const auto errors_by = [&](Source& measured) {
      return evaluate_model(*model, measured, {}, {}, silent_progress(), Detail::quality).total;
    };
    const Errors of = errors_by(drawn), by = errors_by(drawn_jointless);
    CHECK(of.max == by.max);
    CHECK(of.mse == by.mse);
  }
}

TEST_CASE("recipes and methods without joints learn what they do to vertices") {
  FaceRig rig;
  RigSource source(rig.rig);
  const Folder folder, compared;
  BakeOptions options;
  options.recipe = "linear";
  options.poses = 100;
  options.work = folder.path();
  const PackedModel model = archive::read_archive(bake_face(source, options, silent_progress()).archive).model;
  CHECK(model.rest.driven.empty());
  CHECK(worst_of(model, source) < 0.5);
  // By the backend of the rig, as by the source.
  JointlessSource jointless(source);
  RigEvaluator evaluator(jointless);
  const std::vector<float> poses = {0.5f, -1, 1, -1, 1, 0.75f, 0, 0, 0.25f, 0, 0, 1};
  std::vector<float> points(2 * jointless.rest().points.size());
  evaluator.evaluate(poses, 2, points);
  std::vector<float> expected = surface_of(source, {poses.begin(), poses.begin() + 6});
  const std::vector<float> second = surface_of(source, {poses.begin() + 6, poses.end()});
  expected.insert(expected.end(), second.begin(), second.end());
  CHECK(points == expected);
  options.work = compared.path();
  options.epochs = 1;
  const CompareReport report = compare(source, {"linear", "kanyuk2018", "compact"}, options, silent_progress());
  REQUIRE(report.methods.size() == 3);
  for (const MethodReport& method : report.methods)
    CHECK(archive::read_archive(method.archive).model.rest.driven.empty());
}

TEST_CASE("weights are rounded to sum to 1, and what does not is told") {
  Skin skin{3, {0, 1, 2, 0, 1, 2}, {1 / 3.0f, 1 / 3.0f, 1 / 3.0f, 0.5f, 0.25f, 0}};
  round_weights(skin);
  CHECK(skin.weights[0] + skin.weights[1] + skin.weights[2] == 1);
  CHECK(skin.weights[3] + skin.weights[4] == 0.75f);
  DrivenJoints driven;
  for (const char* name : {"a", "b", "c"})
    driven.joints.push_back({name, no_joint, 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
  driven.skin = {3, {0, 1, 2}, {0.5f, 0.5f, 0.25f}};
  round_weights(driven.skin);
  const std::string what = failure(Status::bad_data, [&] { check(driven, 1); });
  CHECK_MESSAGE(contains(what, "vertex 0 has weights of driven joints that sum to 1.25, more than 1"), what);
}

TEST_CASE("what a rig says wrongly of its joints is refused") {
  const auto refused = [](const std::function<void(FaceRig&)>& change, const char* message) {
    FaceRig rig;
    change(rig);
    const std::string what = failure(Status::rig, [&] { RigSource(rig.rig); });
    CHECK_MESSAGE(contains(what, message), what);
  };
  refused([](FaceRig& r) { r.numbers[1] = FB_JOINT_PIVOT_X; },
          "joint_numbers of joint 1 is 0x200; a rig has FB_JOINT_ROTATE, _MOVE and _SCALE only");
  refused([](FaceRig& r) { r.joints[1].parent = FB_NO_JOINT; }, "joint \"jaw\", which controls move, hangs on none");
  refused([](FaceRig& r) { r.weights[0] = 0.5f; }, "vertex 0 has weights of joints that sum to 0.5, not 1");
  refused([](FaceRig& r) { r.numbers[0] = FB_JOINT_ROTATE, r.weights[0] = 1.5f; },
          "vertex 0 has weights of joints that sum to 1.5, more than 1");
  // Without the flag, only a host moves joints.
  FaceRig rig;
  rig.rig.struct_size = offsetof(fb_rig, joint_numbers);
  CHECK(RigSource(rig.rig).rest().driven.empty());
}

}  // namespace test_driven_rig
