#include "bake/rig/gltf/gltf_joints.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <tuple>

#include "bake/rig/gltf/animation_target.h"
#include "base/checked.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Eigen::Affine3d;

// How far the same joint of two skins may put vertices apart, over the size of the mesh: rounding of floats.
constexpr double same_bind = 1e-6;
// Weights that sum to 1, to this, are kept as they are: rounding of floats.
constexpr double normal_sum = 2e-7;

Frame<float> frame_of(const Affine3d& map) {
  Frame<float> frame;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column)
      frame[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(map.matrix()(row, column));
  return frame;
}

std::optional<Affine3d> inverse_of(const Affine3d& map) {
  Frame<double> frame;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column)
      frame[static_cast<std::size_t>(4 * row + column)] = map.matrix()(row, column);
  if (!inverse(frame)) return std::nullopt;
  return map.inverse();
}

// The length of the diagonal of a mesh's box; its corners are no further from its middle.
double size_of(const std::vector<float>& points, Eigen::Vector3d& middle) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3)
    box.extend(Eigen::Map<const Eigen::Vector3f>(&points[i]).cast<double>());
  if (box.isEmpty()) return 0;
  middle = box.center();
  return box.diagonal().norm();
}

}  // namespace

std::vector<bool> animated_nodes(const tinygltf::Model& model) {
  std::vector<bool> animated(model.nodes.size());
  for (const tinygltf::Animation& animation : model.animations)
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      const AnimationTarget target = target_of(channel);
      if (target.moves_node() && target.node >= 0 && static_cast<std::size_t>(target.node) < animated.size())
        animated[static_cast<std::size_t>(target.node)] = true;
    }
  return animated;
}

std::size_t joint_count(const GltfFile& file, const ShownMesh& shown) {
  if (shown.skin < 0) return 0;
  const tinygltf::Skin& skin = file.model().skins[static_cast<std::size_t>(shown.skin)];
  if (skin.joints.empty()) fail(Status::bad_data, "its skin has no joints");
  for (const int joint : skin.joints)
    if (joint < 0 || static_cast<std::size_t>(joint) >= file.model().nodes.size())
      fail(Status::bad_data, "its skin names node %d of %zu", joint, file.model().nodes.size());
  return skin.joints.size();
}

GltfJoints::GltfJoints(const GltfFile& file, const GltfScene& scene, const std::vector<GltfMesh>& meshes,
                       const std::vector<bool>& moving, bool without_skins)
    : file_(file),
      scene_(scene),
      meshes_(meshes),
      joint_of_node_(file.model().nodes.size(), -1),
      skins_(file.model().skins.size()),
      maps_(meshes.size(), Map::Identity()),
      rigid_(meshes.size(), -1) {
  find_nodes(moving, without_skins);
  place_skins();
  complete_inverses();
  place_unskinned();
  for (std::size_t j = 0; j < joints_.size(); ++j) joints_[j].inverse_bind = frame_of(*inverse_bind_[j]);
  std::vector<std::vector<std::pair<std::uint32_t, float>>> influences;
  for (std::size_t s = 0; s < meshes.size(); ++s) {
    const ShownMesh& shown = scene.meshes()[s];
    const VertexJoints& from = meshes[s].joints;
    for (std::size_t v = 0; v < meshes[s].surface.vertex_count(); ++v) {
      auto& of_vertex = influences.emplace_back();
      if (rigid_[s] >= 0) of_vertex = {{static_cast<std::uint32_t>(rigid_[s]), 1.0f}};
      if (shown.skin < 0) continue;
      const std::vector<std::uint32_t>& joints = skins_[static_cast<std::size_t>(shown.skin)].joints;
      double sum = 0;
      const std::size_t first = v * from.per_vertex;
      for (std::size_t k = first; k < first + from.per_vertex; ++k) sum += std::max(double(from.weights[k]), 0.0);
      if (std::abs(sum - 1) <= normal_sum) sum = 1;
      for (std::size_t k = first; k < first + from.per_vertex; ++k)
        if (from.weights[k] > 0)
          of_vertex.emplace_back(joints[from.joints[k]], static_cast<float>(double(from.weights[k]) / sum));
      if (of_vertex.empty()) of_vertex = {{joints[from.joints[first]], 1.0f}};
    }
  }
  fill_skin(influences);
}

void GltfJoints::fill_skin(const std::vector<std::vector<std::pair<std::uint32_t, float>>>& influences) {
  std::size_t most = 0;
  for (const auto& of_vertex : influences) most = std::max(most, of_vertex.size());
  skin_.influences = checked_u32(most, "influences of a vertex");
  skin_.joints.resize(checked_multiply(influences.size(), most, "influences"));
  skin_.weights.resize(skin_.joints.size());
  for (std::size_t v = 0; v < influences.size(); ++v)
    for (std::size_t k = 0; k < influences[v].size(); ++k) {
      if (influences[v][k].first >= most_joints)
        fail(Status::limit, "it has joint %u; a face has at most %zu", influences[v][k].first, most_joints);
      skin_.joints[v * most + k] = static_cast<std::uint16_t>(influences[v][k].first);
      skin_.weights[v * most + k] = influences[v][k].second;
    }
  tidy(skin_);
  followed_.resize(joints_.size());
  for (std::size_t i = 0; i < skin_.joints.size(); ++i)
    if (skin_.weights[i] > 0) followed_[skin_.joints[i]] = true;
  for (std::size_t j = joints_.size(); j-- > 0;)
    if (followed_[j] && joints_[j].parent != no_joint) followed_[joints_[j].parent] = true;
}

std::optional<std::size_t> GltfJoints::moving_joint(std::size_t node) const {
  const int joint = joint_of_node_[node];
  if (joint < 0 || !followed_[static_cast<std::size_t>(joint)]) return std::nullopt;
  return static_cast<std::size_t>(joint);
}

bool GltfJoints::mirrored(std::size_t s) const {
  const ShownMesh& shown = scene_.meshes()[s];
  if (shown.skin < 0)
    return shown.node >= 0 &&
           (scene_.world(static_cast<std::size_t>(shown.node)) * shown.instance).linear().determinant() < 0;
  const std::vector<double>& sides = skins_[static_cast<std::size_t>(shown.skin)].sides;
  const VertexJoints& from = meshes_[s].joints;
  double sum = 0;
  for (std::size_t k = 0; k < from.joints.size(); ++k) sum += double(from.weights[k]) * sides[from.joints[k]];
  return sum < 0;
}

// A node becomes a joint, and so do all above it, before it.
void GltfJoints::add_node(std::size_t node) {
  std::vector<std::size_t> chain;
  for (int n = static_cast<int>(node); n >= 0 && joint_of_node_[static_cast<std::size_t>(n)] < 0;
       n = scene_.parent(static_cast<std::size_t>(n)))
    chain.push_back(static_cast<std::size_t>(n));
  for (auto n = chain.rbegin(); n != chain.rend(); ++n) {
    const int parent = scene_.parent(*n);
    const std::string& name = file_.model().nodes[*n].name;
    joint_of_node_[*n] = static_cast<int>(joints_.size());
    joints_.push_back(
        {names_.add(name.empty() ? format("node%zu", *n) : name),
         parent < 0 ? no_joint : static_cast<std::uint32_t>(joint_of_node_[static_cast<std::size_t>(parent)]),
         frame_of(scene_.local(*n)),
         {}});
    nodes_.push_back(*n);
    repeats_.push_back(false);
    locals_.push_back(scene_.local(*n));
    inverse_bind_.emplace_back();
  }
}

void GltfJoints::find_nodes(const std::vector<bool>& moving, bool without_skins) {
  for (const ShownMesh& shown : scene_.meshes())
    if (shown.skin >= 0)
      for (const int node : file_.model().skins[static_cast<std::size_t>(shown.skin)].joints)
        add_node(static_cast<std::size_t>(node));
  if (joints_.empty() && !without_skins) return;
  std::vector<bool> seen(moving.size());
  for (const ShownMesh& shown : scene_.meshes())
    for (int n = shown.skin < 0 ? shown.node : -1; n >= 0; n = scene_.parent(static_cast<std::size_t>(n))) {
      if (seen[static_cast<std::size_t>(n)]) break;
      seen[static_cast<std::size_t>(n)] = true;
      if (moving[static_cast<std::size_t>(n)]) add_node(static_cast<std::size_t>(n));
    }
}

// Of all vertices, to the joints of the skins that their meshes have.
void GltfJoints::add_weights() {
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    const int index = scene_.meshes()[s].skin;
    if (index < 0) continue;
    std::vector<double>& weights = skins_[static_cast<std::size_t>(index)].weights;
    weights.resize(file_.model().skins[static_cast<std::size_t>(index)].joints.size());
    const VertexJoints& joints = meshes_[s].joints;
    for (std::size_t k = 0; k < joints.weights.size(); ++k) weights[joints.joints[k]] += double(joints.weights[k]);
  }
}

void GltfJoints::read_skin(int index, FileSkin& skin) const {
  const tinygltf::Skin& from = file_.model().skins[static_cast<std::size_t>(index)];
  std::vector<float> inverses;
  if (from.inverseBindMatrices >= 0)
    inverses = file_.floats(from.inverseBindMatrices, 16, std::nullopt, "inverse bind matrices");
  if (!inverses.empty() && inverses.size() / 16 < from.joints.size())
    fail(Status::bad_data, "its skin has %zu inverse bind matrices for %zu joints", inverses.size() / 16,
         from.joints.size());
  for (std::size_t j = 0; j < from.joints.size(); ++j) {
    skin.nodes.push_back(static_cast<std::size_t>(from.joints[j]));
    skin.inverses.push_back(Map::Identity());
    if (!inverses.empty())
      skin.inverses.back() = Map(Eigen::Map<const Eigen::Matrix4f>(&inverses[16 * j]).cast<double>());
    const double volume = (scene_.world(skin.nodes.back()) * skin.inverses.back()).linear().determinant();
    skin.sides.push_back(volume < 0 ? -1 : volume > 0 ? 1 : 0);
  }
  skin.joints.resize(skin.nodes.size());
}

void GltfJoints::place_skins() {
  add_weights();
  std::vector<std::size_t> shown(meshes_.size());
  std::iota(shown.begin(), shown.end(), std::size_t{0});
  std::stable_partition(shown.begin(), shown.end(), [&](std::size_t s) { return !meshes_[s].targets.empty(); });
  for (const std::size_t s : shown) {
    const int index = scene_.meshes()[s].skin;
    if (index < 0) continue;
    FileSkin& skin = skins_[static_cast<std::size_t>(index)];
    in_mesh(scene_.meshes()[s], [&] {
      if (!skin.nodes.empty()) return;
      read_skin(index, skin);
      std::vector<std::size_t> order(skin.nodes.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::vector<double> of_mesh(skin.nodes.size());
      const VertexJoints& joints = meshes_[s].joints;
      for (std::size_t k = 0; k < joints.weights.size(); ++k) of_mesh[joints.joints[k]] += double(joints.weights[k]);
      std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t j) { return of_mesh[j]; });
      if (!place_by_known(skin, order) && !place_at_rest(skin, order))
        fail(Status::bad_data, "its skin has no joint whose matrices can be inverted");
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      const double size = size_of(meshes_[s].surface.points, middle);
      add_inverses(skin, (skin.map.linear() * Eigen::Vector3d::Constant(size)).norm() + (skin.map * middle).norm());
    });
    maps_[s] = skin.map;
  }
}

// By a joint that another skin has, too.
bool GltfJoints::place_by_known(FileSkin& skin, const std::vector<std::size_t>& order) const {
  for (const std::size_t j : order) {
    const auto& known = inverse_bind_[static_cast<std::size_t>(joint_of_node_[skin.nodes[j]])];
    if (!known || !inverse_of(skin.inverses[j])) continue;
    if (const auto back = inverse_of(*known)) {
      skin.map = *back * skin.inverses[j];
      return true;
    }
  }
  return false;
}

bool GltfJoints::place_at_rest(FileSkin& skin, const std::vector<std::size_t>& order) const {
  for (const std::size_t j : order) {
    skin.map = scene_.world(skin.nodes[j]) * skin.inverses[j];
    if (inverse_of(skin.map)) return true;
  }
  return false;
}

// `size`: how far vertices of the mesh are from the origin, in the space of the character.
void GltfJoints::add_inverses(FileSkin& skin, double size) {
  const Map back = skin.map.inverse();
  for (std::size_t j = 0; j < skin.nodes.size(); ++j) {
    const Map inverse = skin.inverses[j] * back;
    auto joint = static_cast<std::size_t>(joint_of_node_[skin.nodes[j]]);
    if (!inverse_bind_[joint]) inverse_bind_[joint] = inverse;
    const Eigen::Matrix4d apart = inverse.matrix() - inverse_bind_[joint]->matrix();
    const double unit = inverse.linear().norm() * size;
    if (apart.topLeftCorner<3, 3>().norm() * size + apart.topRightCorner<3, 1>().norm() > same_bind * unit &&
        skin.weights[j] > 0) {
      joints_.push_back(
          {names_.add(joints_[joint].name), static_cast<std::uint32_t>(joint), frame_of(Map::Identity()), {}});
      nodes_.push_back(skin.nodes[j]);
      repeats_.push_back(true);
      locals_.push_back(Map::Identity());
      inverse_bind_.emplace_back(inverse);
      joint = joints_.size() - 1;
    }
    skin.joints[j] = checked_u32(joint, "joints");
  }
}

// Joints of no skin were bound as they are at rest, in their parents.
void GltfJoints::complete_inverses() {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (inverse_bind_[j]) continue;
    const std::uint32_t parent = joints_[j].parent;
    const auto local = inverse_of(parent == no_joint ? scene_.world(nodes_[j]) : scene_.local(nodes_[j]));
    if (!local)
      inverse_bind_[j] = Map::Identity();
    else
      inverse_bind_[j] = parent == no_joint ? *local : *local * *inverse_bind_[parent];
  }
}

// From a node to the joint that it is or hangs on, and that joint; -1, and to the scene, where there is none.
std::pair<int, GltfJoints::Map> GltfJoints::find_joint(std::size_t node, std::vector<std::optional<Map>>& to_joint) {
  std::vector<std::size_t> chain;
  int at = static_cast<int>(node);
  for (; at >= 0 && joint_of_node_[static_cast<std::size_t>(at)] < 0 && !to_joint[static_cast<std::size_t>(at)];
       at = scene_.parent(static_cast<std::size_t>(at)))
    chain.push_back(static_cast<std::size_t>(at));
  Map map = Map::Identity();
  int joint = -1;
  if (at >= 0 && to_joint[static_cast<std::size_t>(at)]) {
    map = *to_joint[static_cast<std::size_t>(at)];
    joint = hangs_on_[static_cast<std::size_t>(at)];
  } else if (at >= 0) {
    joint = joint_of_node_[static_cast<std::size_t>(at)];
  }
  for (auto n = chain.rbegin(); n != chain.rend(); ++n) {
    map = map * scene_.local(*n);
    to_joint[*n] = map;
    hangs_on_[*n] = joint;
  }
  return {joint, map};
}

void GltfJoints::place_unskinned() {
  hangs_on_.assign(joint_of_node_.size(), -1);
  std::vector<std::optional<Map>> to_joint(joint_of_node_.size());  // of nodes that were asked for
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    const ShownMesh& shown = scene_.meshes()[s];
    if (shown.skin >= 0 || shown.node < 0) continue;
    std::tie(rigid_[s], maps_[s]) = find_joint(static_cast<std::size_t>(shown.node), to_joint);
    maps_[s] = maps_[s] * shown.instance;
    if (rigid_[s] < 0) continue;
    const auto back = inverse_of(*inverse_bind_[static_cast<std::size_t>(rigid_[s])]);
    in_mesh(shown, [&] {
      if (!back)
        fail(Status::bad_data, "the inverse bind matrix of its joint \"%s\" cannot be inverted",
             joints_[static_cast<std::size_t>(rigid_[s])].name.c_str());
    });
    maps_[s] = *back * maps_[s];
  }
}

}  // namespace fb::bake
