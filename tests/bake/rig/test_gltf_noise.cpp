// Which channels of joints are controls: those that move, not those that exporters' arithmetic makes tremble.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"

namespace test_gltf_noise {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

using Eigen::Affine3d;
using Eigen::Affine3f;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;

// How an exporter stores quaternions.
enum class Stored { floats, shorts, four_decimals };

// A chain of joints, "joint0" to "joint7", each with a vertex of a strip; a mesh far away that makes the scene large.
// joint0 turns around its y axis and walks along x, and what `move` does to the last joint. Each frame is computed as
// exporters do it: places of all joints in the scene, in floats, and a joint in its parent from these.
struct Chain {
  static constexpr std::size_t joints = 8;
  std::size_t frames = 48;
  double size = 1;       // metres of one unit in which it is about 4 long
  double scene = 0;      // of the other mesh; 0: there is none
  bool in_world = true;  // without, joints are written as they are, exactly
  Stored stored = Stored::floats;
  double noise = 0;  // added to every number of quaternions
  std::function<void(double phase, Vector3d& offset, Quaterniond& turn)> move = [](double, Vector3d&, Quaterniond&) {};

  Affine3d local(std::size_t joint, double phase) const {
    Affine3d map = Affine3d::Identity();
    Vector3d at = size * Vector3d(0.1 * double(joint), 0.5, -0.03 * double(joint));
    if (joint == 0) at.setZero();
    Quaterniond turn(Eigen::AngleAxisd(0.2 * double(joint + 1), Vector3d(1, 2 - double(joint), 0.5).normalized()));
    if (joint == 0) {
      at.x() += size * 0.4 * std::sin(phase);
      turn = Quaterniond(Eigen::AngleAxisd(0.6 * std::sin(phase), Vector3d::UnitY()));
    }
    Vector3d offset = Vector3d::Zero();
    Quaterniond more = Quaterniond::Identity();
    if (joint + 1 == joints) move(phase, offset, more);
    map.translate(at + offset);
    map.rotate(turn * more);
    return map;
  }

  // Of each joint, in its parent, as an exporter has it.
  std::vector<Affine3f> exported(double phase) const {
    std::vector<Affine3f> locals, worlds;
    for (std::size_t j = 0; j < joints; ++j) {
      worlds.push_back(local(j, phase).cast<float>());
      if (!in_world) {
        locals.push_back(worlds[j]);
        continue;
      }
      if (j > 0) worlds[j] = worlds[j - 1] * worlds[j];
      locals.push_back(j > 0 ? worlds[j - 1].inverse() * worlds[j] : worlds[j]);
    }
    return locals;
  }

  OpenedSource open() const;
};

class ChainWriter {
 public:
  explicit ChainWriter(const Chain& chain) : chain_(chain), buffer_(json_) {
    json_ = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", json::array({{{"nodes", {0, Chain::joints}}}})}};
    add_nodes();
    add_mesh();
    add_animation();
  }
  std::string glb() const { return glb_file(json_, buffer_.data); }

 private:
  struct Parts {
    Eigen::Vector3f translation, scale;
    Eigen::Quaternionf rotation;
  };
  static Parts parts_of(const Affine3f& map) {
    Parts parts;
    parts.translation = map.translation();
    parts.scale = map.linear().colwise().norm();
    parts.rotation = Eigen::Quaternionf(Eigen::Matrix3f(map.linear() * parts.scale.cwiseInverse().asDiagonal()));
    parts.rotation.normalize();
    return parts;
  }

  template <class Vector>
  static std::vector<float> list(const Vector& vector) {
    return {vector.data(), vector.data() + vector.size()};
  }

  void add_nodes() {
    const std::vector<Affine3f> locals = chain_.exported(0);
    for (std::size_t j = 0; j < Chain::joints; ++j) {
      const Parts parts = parts_of(locals[j]);
      json_["nodes"].push_back({{"name", "joint" + std::to_string(j)},
                                {"translation", list(parts.translation)},
                                {"rotation", list(parts.rotation.coeffs())},
                                {"scale", list(parts.scale)}});
      if (j + 1 < Chain::joints) json_["nodes"][j]["children"] = {j + 1};
    }
    json_["nodes"].push_back({{"name", "body"}, {"mesh", 0}, {"skin", 0}});
    if (chain_.scene > 0) {
      json_["nodes"].push_back({{"name", "ground"}, {"mesh", 1}});
      json_["scenes"][0]["nodes"].push_back(Chain::joints + 1);
    }
  }

  void add_mesh() {
    std::vector<float> points, weights, inverses;
    std::vector<std::uint16_t> corners;
    std::vector<std::uint8_t> joints;
    Affine3d world = Affine3d::Identity();
    for (std::size_t j = 0; j < Chain::joints; ++j) {
      world = world * chain_.local(j, 0);
      for (const double x : {-0.1, 0.3}) {
        const std::vector<float> at =
            list(Eigen::Vector3f((world * Vector3d(chain_.size * Vector3d(x, 0.2, 0.1))).cast<float>()));
        points.insert(points.end(), at.begin(), at.end());
        joints.insert(joints.end(), {static_cast<std::uint8_t>(j), 0, 0, 0});
        weights.insert(weights.end(), {1, 0, 0, 0});
      }
      const std::vector<float> inverse = list(Eigen::Matrix4f(world.inverse().matrix().cast<float>()));
      inverses.insert(inverses.end(), inverse.begin(), inverse.end());
      for (const std::size_t corner : {2 * j, 2 * j + 1, 2 * j + 2, 2 * j + 1, 2 * j + 3, 2 * j + 2})
        if (j + 1 < Chain::joints) corners.push_back(static_cast<std::uint16_t>(corner));
    }
    const json strip = {{"attributes",
                         {{"POSITION", buffer_.accessor(points, "VEC3", 3)},
                          {"JOINTS_0", buffer_.accessor(joints, "VEC4", 4)},
                          {"WEIGHTS_0", buffer_.accessor(weights, "VEC4", 4)}}},
                        {"indices", buffer_.accessor(corners, "SCALAR", 1)}};
    add_mesh_of(strip);
    const json skin = {{"joints", {0, 1, 2, 3, 4, 5, 6, 7}},
                       {"inverseBindMatrices", buffer_.accessor(inverses, "MAT4", 16)}};
    json_["skins"] = json::array({skin});
    if (chain_.scene == 0) return;
    const auto far = static_cast<float>(chain_.scene);
    const std::vector<float> points_far = {-far, 0, -far, far, 0, -far, far, 0, far};
    add_mesh_of({{"attributes", {{"POSITION", buffer_.accessor(points_far, "VEC3", 3)}}},
                 {"indices", buffer_.accessor(std::vector<std::uint16_t>{0, 1, 2}, "SCALAR", 1)}});
  }

  void add_mesh_of(const json& primitive) { json_["meshes"].push_back({{"primitives", json::array({primitive})}}); }

  int add_rotations(std::vector<float> values) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (float& value : values) value = static_cast<float>(double(value) + chain_.noise * normal(random));
    if (chain_.stored == Stored::four_decimals)
      for (float& value : values) value = std::round(value * 1e4f) / 1e4f;
    if (chain_.stored != Stored::shorts) return buffer_.accessor(values, "VEC4", 4);
    std::vector<std::int16_t> shorts;
    for (const float value : values) shorts.push_back(static_cast<std::int16_t>(std::lround(value * 32767)));
    const int index = buffer_.accessor(shorts, "VEC4", 4);
    json_["accessors"][std::size_t(index)]["normalized"] = true;
    return index;
  }

  void add_animation() {
    std::vector<float> times;
    std::vector<std::vector<float>> values(3 * Chain::joints);
    for (std::size_t f = 0; f < chain_.frames; ++f) {
      times.push_back(static_cast<float>(f) / 30);
      const std::vector<Affine3f> locals = chain_.exported(2 * std::acos(-1.0) * double(f) / double(chain_.frames));
      for (std::size_t j = 0; j < Chain::joints; ++j) {
        const Parts parts = parts_of(locals[j]);
        const std::vector<float> all[] = {list(parts.translation), list(parts.rotation.coeffs()), list(parts.scale)};
        for (std::size_t k = 0; k < 3; ++k)
          values[3 * j + k].insert(values[3 * j + k].end(), all[k].begin(), all[k].end());
      }
    }
    const int input = buffer_.accessor(times, "SCALAR", 1);
    const char* const paths[] = {"translation", "rotation", "scale"};
    json animation = {{"name", "walk"}};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int output = i % 3 == 1 ? add_rotations(values[i]) : buffer_.accessor(values[i], "VEC3", 3);
      animation["samplers"].push_back({{"input", input}, {"output", output}});
      animation["channels"].push_back({{"sampler", i}, {"target", {{"node", i / 3}, {"path", paths[i % 3]}}}});
    }
    json_["animations"] = json::array({animation});
  }

  const Chain& chain_;
  json json_;
  GltfBuffer buffer_;
};

OpenedSource Chain::open() const {
  const std::string bytes = ChainWriter(*this).glb();
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "chain");
}

std::set<std::string> controls_of(const Source& rig) {
  std::set<std::string> names;
  for (const Control& control : rig.schema().controls) names.insert(control.name);
  return names;
}

bool notes_have(const Source& rig, const std::string& words) {
  return std::ranges::any_of(rig.notes(), [&](const std::string& note) { return contains(note, words); });
}

const std::set<std::string> root_controls = {"joint0.tx", "joint0.ry"};

void turn_a_little(double phase, Vector3d&, Quaterniond& turn) {
  turn = Eigen::AngleAxisd(2e-4 * (1 - std::cos(phase)), Vector3d::UnitX());
}

}  // namespace

TEST_CASE("joints that only exporters' arithmetic moves are no controls, in any unit") {
  for (const double size : {0.001, 0.01, 1.0, 100.0, 1000.0}) {
    CAPTURE(size);
    Chain chain;
    chain.size = size;
    const auto rig = chain.open();
    CHECK(controls_of(*rig) == root_controls);
    CHECK(notes_have(*rig, "channels of joints move by no more than the rounding of the file, and are no controls"));
    chain.frames = 480;
    CHECK(controls_of(*chain.open()) == root_controls);
  }
}

TEST_CASE("noise of 1e-7 in quaternions is no motion") {
  for (const bool in_world : {false, true}) {
    Chain chain;
    chain.in_world = in_world;
    chain.noise = 1e-7;
    CHECK(controls_of(*chain.open()) == root_controls);
  }
}

TEST_CASE("how exactly rotations are stored is found in the file") {
  for (const Stored stored : {Stored::shorts, Stored::four_decimals}) {
    Chain chain;
    chain.stored = stored;
    CHECK(controls_of(*chain.open()) == root_controls);
    chain.move = [](double phase, Vector3d&, Quaterniond& turn) {
      turn = Eigen::AngleAxisd(0.01 * std::sin(phase), Vector3d::UnitX());
    };
    CHECK(controls_of(*chain.open()).contains("joint7.rx"));
  }
}

TEST_CASE("a small motion in a large scene is kept, in any unit") {
  for (const double size : {0.001, 1.0, 1000.0}) {
    CAPTURE(size);
    Chain chain;
    chain.size = size;
    chain.scene = 1000 * size;
    chain.move = turn_a_little;  // by 0.02 degrees
    CHECK(controls_of(*chain.open()) == std::set<std::string>{"joint0.tx", "joint0.ry", "joint7.rx"});
    chain.move = [&](double phase, Vector3d& offset, Quaterniond&) { offset.y() = 1e-4 * size * std::sin(phase); };
    CHECK(controls_of(*chain.open()) == std::set<std::string>{"joint0.tx", "joint0.ry", "joint7.ty"});
  }
}

TEST_CASE("joints that move beside morph targets are named") {
  GltfAvatar avatar;
  const std::string bytes = avatar.glb();
  const auto rig = open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar");
  CHECK(notes_have(*rig,
                   "animations move joints that are no controls; --joints controls makes all of them controls, "
                   "--control-joint NAME one: \"Neck\", \"Head\""));
  const auto told = open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar", {JointUse::ignored, {}});
  CHECK_FALSE(notes_have(*told, "--joints"));
}

}  // namespace test_gltf_noise
