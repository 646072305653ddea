#include "bake/rig/gltf/gltf_scene.h"

#include <tiny_gltf.h>

namespace fb::bake {
namespace {

// Without its matrix.
NodeParts stored_parts(const tinygltf::Node& node) {
  NodeParts parts;
  if (node.translation.size() == 3) parts.translation = Eigen::Vector3d(node.translation.data());
  if (node.rotation.size() == 4) parts.rotation = Eigen::Quaterniond(node.rotation.data()).normalized();
  if (node.scale.size() == 3) parts.scale = Eigen::Vector3d(node.scale.data());
  return parts;
}

Eigen::Affine3d local_map(const tinygltf::Node& node) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  if (node.matrix.size() == 16) map.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  return map * place_of(stored_parts(node));
}

// Fails unless `index` is -1 or below `count`.
void check_index(int index, std::size_t count, std::size_t node, const char* what) {
  if (index < -1 || (index >= 0 && static_cast<std::size_t>(index) >= count))
    fail(Status::bad_data, "node %zu names %s %d of %zu", node, what, index, count);
}

// The parent of each node; -1: none.
std::vector<int> parents_of(const std::vector<tinygltf::Node>& nodes) {
  std::vector<int> parents(nodes.size(), -1);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (const int child : nodes[n].children) {
      if (child < 0 || static_cast<std::size_t>(child) >= nodes.size())
        fail(Status::bad_data, "node %zu has the child %d of %zu nodes", n, child, nodes.size());
      int& parent = parents[static_cast<std::size_t>(child)];
      if (parent >= 0) fail(Status::bad_data, "node %d has two parents, %d and %zu", child, parent, n);
      parent = static_cast<int>(n);
    }
  return parents;
}

// The nodes that have no parents.
std::vector<int> roots_of(const std::vector<int>& parents) {
  std::vector<int> roots;
  for (std::size_t n = 0; n < parents.size(); ++n)
    if (parents[n] < 0) roots.push_back(static_cast<int>(n));
  return roots;
}

// Calls visit(node) for nodes and all below them, parents first, but for those that are seen, which it marks. Each node
// has one parent at most.
template <class Visit>
void visit_tree(const std::vector<tinygltf::Node>& nodes, std::vector<int> next, std::vector<bool>& seen,
                const Visit& visit) {
  while (!next.empty()) {
    const auto node = static_cast<std::size_t>(next.back());
    next.pop_back();
    if (seen[node]) continue;
    seen[node] = true;
    visit(node);
    next.insert(next.end(), nodes[node].children.begin(), nodes[node].children.end());
  }
}

// The nodes with which the default scene begins.
std::vector<int> nodes_of_scene(const tinygltf::Model& model, const std::vector<int>& roots) {
  if (model.defaultScene < 0) return roots;
  if (static_cast<std::size_t>(model.defaultScene) >= model.scenes.size())
    fail(Status::bad_data, "its scene is %d of %zu", model.defaultScene, model.scenes.size());
  std::vector<int> nodes = model.scenes[static_cast<std::size_t>(model.defaultScene)].nodes;
  for (const int node : nodes)
    if (node < 0 || static_cast<std::size_t>(node) >= model.nodes.size())
      fail(Status::bad_data, "its scene names node %d of %zu", node, model.nodes.size());
  return nodes;
}

std::string name_of_shown(const tinygltf::Mesh& mesh, std::size_t index, const std::string& node) {
  if (!node.empty()) return node;
  return mesh.name.empty() ? format("mesh%zu", index) : mesh.name;
}

// The first instance of EXT_mesh_gpu_instancing; nothing of a node without.
std::optional<Eigen::Affine3d> first_instance(const GltfFile& file, const tinygltf::Node& node) {
  const auto found = node.extensions.find("EXT_mesh_gpu_instancing");
  if (found == node.extensions.end() || !found->second.IsObject()) return std::nullopt;
  const tinygltf::Value& attributes = found->second.Get("attributes");
  const auto first = [&](const char* name, std::size_t width) {
    if (!attributes.IsObject() || !attributes.Get(name).IsInt()) return std::vector<float>();
    std::vector<float> all = file.floats(attributes.Get(name).GetNumberAsInt(), width, std::nullopt, "instances");
    all.resize(width);
    return all;
  };
  NodeParts parts;
  if (const auto at = first("TRANSLATION", 3); !at.empty())
    parts.translation = Eigen::Vector3f(at.data()).cast<double>();
  if (const auto turn = first("ROTATION", 4); !turn.empty())
    parts.rotation = Eigen::Quaternionf(turn.data()).cast<double>().normalized();
  if (const auto scale = first("SCALE", 3); !scale.empty()) parts.scale = Eigen::Vector3f(scale.data()).cast<double>();
  return place_of(parts);
}

}  // namespace

Eigen::Affine3d place_of(const NodeParts& parts) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.translate(parts.translation);
  map.rotate(parts.rotation);
  map.scale(parts.scale);
  return map;
}

std::optional<NodeParts> parts_of(const tinygltf::Node& node) {
  constexpr double right_angle = 1e-5;
  if (node.matrix.size() != 16) return stored_parts(node);
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  NodeParts parts;
  parts.translation = matrix.topRightCorner<3, 1>();
  parts.scale = matrix.topLeftCorner<3, 3>().colwise().norm();
  if (matrix.topLeftCorner<3, 3>().determinant() < 0) parts.scale.x() *= -1;
  if (!(parts.scale.cwiseAbs().minCoeff() > 0) || !parts.scale.allFinite()) return std::nullopt;
  const Eigen::Matrix3d axes = matrix.topLeftCorner<3, 3>() * parts.scale.cwiseInverse().asDiagonal();
  if (!((axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < right_angle))
    return std::nullopt;
  parts.rotation = Eigen::Quaterniond(axes).normalized();
  return parts;
}

std::string UniqueNames::add(const std::string& name) {
  const auto [at, fresh] = next_.try_emplace(name, 2);
  if (fresh) return name;
  std::string unique;
  do unique = format("%s (%d)", name.c_str(), at->second++);
  while (!next_.try_emplace(unique, 2).second);
  return unique;
}

void GltfScene::place_nodes(const GltfFile& file) {
  const tinygltf::Model& model = file.model();
  std::size_t placed = 0;
  std::vector<bool> seen(model.nodes.size());
  locals_.resize(model.nodes.size());
  worlds_.resize(model.nodes.size());
  visit_tree(model.nodes, roots_of(parents_), seen, [&](std::size_t n) {
    locals_[n] = worlds_[n] = local_map(model.nodes[n]);
    if (parents_[n] >= 0) worlds_[n] = worlds_[static_cast<std::size_t>(parents_[n])] * locals_[n];
    ++placed;
  });
  if (placed < model.nodes.size()) fail(Status::bad_data, "some of its nodes are their own parents");
}

// `shown`: of nodes.
void GltfScene::note_hidden(const GltfFile& file, const std::vector<bool>& shown, LeftOut& left_out) const {
  const tinygltf::Model& model = file.model();
  std::vector<bool> seen = shown;
  const auto note = [&](std::size_t n) {
    const auto mesh = static_cast<std::size_t>(model.nodes[n].mesh);
    if (model.nodes[n].mesh < 0 || mesh >= model.meshes.size()) return false;
    left_out.add("meshes that the default scene does not show are left out",
                 name_of_shown(model.meshes[mesh], mesh, model.nodes[n].name));
    return true;
  };
  for (std::size_t s = 0; s < model.scenes.size(); ++s) {
    const std::string& name = model.scenes[s].name;
    std::vector<int> nodes = model.scenes[s].nodes;
    std::erase_if(nodes, [&](int n) { return n < 0 || static_cast<std::size_t>(n) >= seen.size(); });
    bool hidden = false;
    visit_tree(model.nodes, std::move(nodes), seen, [&](std::size_t n) { hidden |= note(n); });
    if (hidden)
      left_out.add("scenes besides the default one are left out", name.empty() ? format("scene%zu", s) : name);
  }
  for (std::size_t n = 0; n < seen.size(); ++n)
    if (!seen[n]) note(n);
}

GltfScene::GltfScene(const GltfFile& file, const std::set<std::string>& broken, LeftOut& left_out) {
  const tinygltf::Model& model = file.model();
  parents_ = parents_of(model.nodes);
  place_nodes(file);
  std::vector<bool> shown(model.nodes.size());
  visit_tree(model.nodes, nodes_of_scene(model, roots_of(parents_)), shown, [](std::size_t) {});
  note_hidden(file, shown, left_out);
  UniqueNames names;
  for (std::size_t n = 0; n < model.nodes.size(); ++n) {
    const tinygltf::Node& node = model.nodes[n];
    if (!shown[n]) continue;
    check_index(node.mesh, model.meshes.size(), n, "mesh");
    check_index(node.skin, model.skins.size(), n, "skin");
    if (node.mesh < 0) continue;
    const auto mesh = static_cast<std::size_t>(node.mesh);
    const std::string name = name_of_shown(model.meshes[mesh], mesh, node.name);
    ShownMesh made{names.add(name), mesh, static_cast<int>(n), node.skin};
    if (broken.contains(made.name)) continue;
    const auto instance = in_mesh(made, [&] { return first_instance(file, node); });
    made.instance = instance.value_or(made.instance);
    meshes_.push_back(std::move(made));
    if (instance) left_out.add("EXT_mesh_gpu_instancing: the first instance is read, and others are left out", name);
  }
  for (std::size_t m = 0; model.nodes.empty() && m < model.meshes.size(); ++m) {
    const std::string name = names.add(name_of_shown(model.meshes[m], m, ""));
    if (!broken.contains(name)) meshes_.push_back({name, m, -1, -1});
  }
}

}  // namespace fb::bake
