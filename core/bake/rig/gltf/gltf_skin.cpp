#include "bake/rig/gltf/gltf_skin.h"

#include <tiny_gltf.h>

#include "base/status.h"

namespace fb::bake {
namespace {

using Map = VertexMaps::Map;

// Of each joint: from the mesh to the joint, and from there to the scene.
std::vector<Map> joint_maps(const GltfFile& file, const GltfScene& scene, const tinygltf::Skin& skin) {
  std::vector<float> inverses;
  if (skin.inverseBindMatrices >= 0)
    inverses = file.floats(skin.inverseBindMatrices, 16, std::nullopt, "inverse bind matrices");
  if (!inverses.empty() && inverses.size() / 16 < skin.joints.size())
    fail(Status::bad_data, "its skin has %zu inverse bind matrices for %zu joints", inverses.size() / 16,
         skin.joints.size());
  std::vector<Map> maps;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    Eigen::Affine3d map = scene.world(static_cast<std::size_t>(skin.joints[j]));
    if (!inverses.empty())
      map = map * Eigen::Affine3d(Eigen::Map<const Eigen::Matrix4f>(&inverses[16 * j]).cast<double>());
    maps.emplace_back(map.matrix().topRows<3>());
  }
  return maps;
}

}  // namespace

std::size_t joint_count(const GltfFile& file, const ShownMesh& shown) {
  if (shown.skin < 0) return 0;
  const tinygltf::Skin& skin = file.model().skins[static_cast<std::size_t>(shown.skin)];
  if (skin.joints.empty()) fail(Status::bad_data, "its skin has no joints");
  for (const int joint : skin.joints)
    if (joint < 0 || static_cast<std::size_t>(joint) >= file.model().nodes.size())
      fail(Status::bad_data, "its skin names node %d of %zu", joint, file.model().nodes.size());
  return skin.joints.size();
}

VertexMaps vertex_maps(const GltfFile& file, const GltfScene& scene, const ShownMesh& shown, const GltfMesh& mesh) {
  if (shown.node < 0) return VertexMaps({Map::Identity()});
  if (shown.skin < 0) return VertexMaps({Map(scene.world(static_cast<std::size_t>(shown.node)).matrix().topRows<3>())});
  const std::vector<Map> of_joints = joint_maps(file, scene, file.model().skins[static_cast<std::size_t>(shown.skin)]);
  const VertexJoints& joints = mesh.joints;
  std::vector<Map> maps(mesh.surface.vertex_count(), Map::Zero());
  for (std::size_t v = 0; v < maps.size(); ++v) {
    const std::size_t first = v * joints.per_vertex;
    double sum = 0;
    for (std::size_t k = first; k < first + joints.per_vertex; ++k) {
      if (joints.weights[k] == 0) continue;
      maps[v] += double(joints.weights[k]) * of_joints[joints.joints[k]];
      sum += double(joints.weights[k]);
    }
    maps[v] = sum > 0 ? Map(maps[v] / sum) : of_joints[joints.joints[first]];
  }
  return VertexMaps(std::move(maps));
}

}  // namespace fb::bake
