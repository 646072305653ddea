#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/gltf_scene.h"

namespace fb::bake {

// Maps from a mesh to the scene: one for all vertices, or one for each.
class VertexMaps {
 public:
  using Map = Eigen::Matrix<double, 3, 4>;
  explicit VertexMaps(std::vector<Map> maps) : maps_(std::move(maps)) {}
  const Map& operator[](std::size_t vertex) const { return maps_[maps_.size() == 1 ? 0 : vertex]; }

 private:
  std::vector<Map> maps_;
};

// Joints of the skin of a shown mesh; 0: it has none. Fails on a skin that names nodes that there are not.
std::size_t joint_count(const GltfFile& file, const ShownMesh& shown);

// Where a shown mesh lies while the nodes are as in the file: by the node's transform, or with a skin by the joints'
// (glTF 2.0, section 3.7.3.2: then the node's own has no effect). A vertex without weights follows its first joint.
VertexMaps vertex_maps(const GltfFile& file, const GltfScene& scene, const ShownMesh& shown, const GltfMesh& mesh);

}  // namespace fb::bake
