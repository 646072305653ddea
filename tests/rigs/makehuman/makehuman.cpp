// The MakeHuman face as a plugin: 59 pose units and 177 bone angles turn a chain of bones; 34 targets move vertices and
// joints before the bones do.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "makehuman/bone_chain.h"
#include "support/plugin_rig.h"
#include "support/regions.h"
#include "support/skin.h"

namespace rigs {
namespace {

// Bones are named after the muscles they stand in for.
const std::vector<Region> regions = {
    {"brows", {"Brow", "eyebrows", "temporalis01", "oculi"}},
    {"lids", {"Lid", "eye-", "orbicularis"}},
    {"eyes", {"Eye", "eye.", "special05", "special06"}},
    {"nose", {"Nose", "Nasolabial", "nose-", "special03", "levator06"}},
    {"tongue", {"Tongue", "tongue"}},
    {"cheeks", {"Cheek", "levator", "risorius", "temporalis02"}},
    {"jaw", {"Chin", "Jaw", "jaw"}},
    {"mouth", {"Lip", "Mouth", "mouth-", "oris", "special01", "special04", "neck-platysma"}},
};

// Offsets of points, each a row of a [targets, points, 3] array; few points move.
class Targets {
 public:
  explicit Targets(const Array<float>& offsets) {
    for (std::size_t target = 0; target < offsets.shape[0]; ++target) {
      for (std::size_t point = 0; point < offsets.shape[1]; ++point) {
        const float* v = offsets.values.data() + 3 * (target * offsets.shape[1] + point);
        if (v[0] != 0 || v[1] != 0 || v[2] != 0) moves_.push_back({point, {v[0], v[1], v[2]}});
      }
      ends_.push_back(moves_.size());
    }
  }

  // points += sum of weight * target.
  void add(const float* weights, std::vector<float>& points) const {
    std::size_t i = 0;
    for (std::size_t target = 0; target < ends_.size(); i = ends_[target++]) {
      if (weights[target] == 0) continue;
      for (; i < ends_[target]; ++i) {
        for (int axis = 0; axis < 3; ++axis)
          points[3 * moves_[i].point + axis] += weights[target] * moves_[i].offset[axis];
      }
    }
  }

 private:
  struct Move {
    std::size_t point;
    float offset[3];
  };
  std::vector<Move> moves_;
  std::vector<std::size_t> ends_;  // of each target's run in moves_
};

// What rig.json says, and its arrays.
struct Data {
  using Names = std::vector<std::string>;

  explicit Data(const RigFolder& folder) : Data(folder, nlohmann::json::parse(folder.text("rig.json"))) {}

  Names bones, units, targets, face_bones;
  std::vector<int> parents;
  std::vector<std::size_t> face_bone_indices;
  Array<float> rest, heads, skin_weights, unit_rotations, target_offsets, head_offsets;
  Array<std::int32_t> faces;

 private:
  Data(const RigFolder& folder, const nlohmann::json& header)
      : units(header.at("units")), targets(header.at("targets")), face_bones(header.at("face_bones")) {
    for (const auto& bone : header.at("bones")) {
      bones.push_back(bone.at("name"));
      parents.push_back(bone.at("parent"));
    }
    for (const std::string& name : face_bones) {
      const auto bone = std::find(bones.begin(), bones.end(), name);
      if (bone == bones.end()) throw std::runtime_error("rig.json: face bone '" + name + "' is not among the bones");
      face_bone_indices.push_back(static_cast<std::size_t>(bone - bones.begin()));
    }
    const auto& files = header.at("arrays");
    rest = folder.floats(files.at("rest"), {0, 3});
    faces = folder.integers(files.at("faces"), {0, 4});
    heads = folder.floats(files.at("heads"), {bones.size(), 3});
    skin_weights = folder.floats(files.at("skin_weights"), {rest.shape[0], bones.size()});
    unit_rotations = folder.floats(files.at("unit_rotvec"), {units.size(), bones.size(), 3});
    target_offsets = folder.floats(files.at("targets"), {targets.size(), rest.shape[0], 3});
    head_offsets = folder.floats(files.at("target_head_deltas"), {targets.size(), bones.size(), 3});
  }
};

class MakeHuman : public PluginRig {
 public:
  explicit MakeHuman(const Data& data)
      : PluginRig("makehuman", "dm"),
        units_(data.units.size()),
        targets_(data.targets.size()),
        angles_(3 * data.face_bones.size()),
        heads_(data.heads.values),
        target_offsets_(data.target_offsets),
        head_offsets_(data.head_offsets),
        skin_(data.skin_weights),
        chain_(data.parents, data.unit_rotations, data.face_bone_indices, heads_, skin_) {
    set_mesh(data.rest, data.faces);
    for (const std::string& unit : data.units) add_control(unit, region_of(unit, regions), 0, 1);
    for (const std::string& target : data.targets) add_control(target, region_of(target, regions), 0, 1);
    for (const std::string& bone : data.face_bones) {
      for (const char* axis : {".rx", ".ry", ".rz"}) add_control(bone + axis, region_of(bone, regions), -15, 15);
    }
    declare_joints(data);
  }

  void evaluate(const float* controls, float* positions) const override { pose(controls, positions, nullptr); }
  void evaluate_skinned(const float* controls, float* positions, float* frames) const override {
    pose(controls, positions, frames);
  }

 private:
  // All bones that vertices follow, or that one of those hangs on. Where targets move the head of one that turns, it
  // turns about another point than at rest: it moves, too.
  void declare_joints(const Data& data) {
    Array<float> weights{{vertices(), chain_.count()}, std::vector<float>(vertices() * chain_.count())};
    for (std::size_t j = 0; j < chain_.count(); ++j) {
      const std::size_t bone = chain_.index(j);
      bool moves = false;
      for (std::size_t target = 0; target < targets_; ++target)
        for (std::size_t axis = 0; axis < 3; ++axis)
          moves = moves || data.head_offsets.values[3 * (target * data.bones.size() + bone) + axis] != 0;
      const std::uint32_t numbers = chain_.turns(j) ? FB_JOINT_ROTATE | (moves ? FB_JOINT_MOVE : 0) : 0;
      add_joint(data.bones[bone], chain_.parent(j), heads_.data() + 3 * bone, numbers);
      for (std::size_t v = 0; v < vertices(); ++v)
        weights.values[v * chain_.count() + j] = data.skin_weights.values[v * data.bones.size() + bone];
    }
    set_skin(weights);
  }

  void pose(const float* controls, float* positions, float* frames) const {
    const float* targets = controls + units_;
    std::vector<float> points = rest(), heads = heads_;
    target_offsets_.add(targets, points);
    head_offsets_.add(targets, heads);
    std::vector<double> radians(angles_);
    for (std::size_t i = 0; i < angles_; ++i) radians[i] = targets[targets_ + i] * (std::numbers::pi / 180);
    std::vector<JointOffset> joints(skin_.joints());
    chain_.evaluate(controls, radians.data(), heads.data(), joints.data(), frames);
    skin_.apply(joints.data(), points.data(), positions);
  }

  std::size_t units_, targets_, angles_;
  std::vector<float> heads_;
  Targets target_offsets_, head_offsets_;
  Skin skin_;
  BoneChain chain_;
};

}  // namespace
}  // namespace rigs

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char* message, std::uint32_t message_size) {
  using namespace rigs;
  return open_plugin(
      "makehuman",
      [](const RigFolder& folder) -> std::unique_ptr<PluginRig> { return std::make_unique<MakeHuman>(Data(folder)); },
      rig, message, message_size);
}
