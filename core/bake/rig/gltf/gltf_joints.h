#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/gltf_scene.h"
#include "model/joints.h"

namespace fb::bake {

// Joints of the skin of a shown mesh; 0: it has none. Fails on a skin that names nodes that there are not.
std::size_t joint_count(const GltfFile& file, const ShownMesh& shown);

// The nodes whose places an animation moves.
std::vector<bool> animated_nodes(const tinygltf::Model& model);

// The joints of a file, and where its meshes lie before skinning.
//
// All meshes share one space, in which the skins of all have one inverse bind matrix a joint: that of the scene where
// the joint that has most of the first mesh with morph targets is at rest, so that a face which the file shows as it
// was bound lies where the file shows it. A mesh without a skin that hangs on a joint follows that joint alone. Where
// skins were bound in poses that do not agree, a joint occurs again, "Head (2)", as its own child. A vertex without
// weights follows its first joint.
//
// Joints are those of the skins, nodes above them, and, where there are skins, nodes that move and that have meshes on
// or below them. In a file without skins there are none, unless joints are controls.
class GltfJoints {
 public:
  // `meshes`: those that scene.meshes() shows. `moving`: of each node, whether it moves. `without_skins`: such nodes
  // are joints even in a file without skins. Fails, naming the mesh, where no matrix of a skin can be inverted.
  GltfJoints(const GltfFile& file, const GltfScene& scene, const std::vector<GltfMesh>& meshes,
             const std::vector<bool>& moving, bool without_skins);

  // From a shown mesh, without node transform and before skinning, to the space of the character.
  const Eigen::Affine3d& map(std::size_t shown) const { return maps_[shown]; }
  // Whether a shown mesh is mirrored where the file shows it at rest, which turns the corners of its faces: glTF 2.0,
  // section 3.7.4. With a skin, which leaves the transform of the node out: where most of its vertices are.
  bool mirrored(std::size_t shown) const;
  const std::vector<Joint>& joints() const { return joints_; }
  // Of the vertices of all meshes, one after the other.
  const Skin& skin() const { return skin_; }
  // The node of a joint, and whether it repeats that of its parent, see above.
  std::size_t node(std::size_t joint) const { return nodes_[joint]; }
  bool repeats(std::size_t joint) const { return repeats_[joint]; }
  // joints(), before rounding.
  const Eigen::Affine3d& local(std::size_t joint) const { return locals_[joint]; }
  const Eigen::Affine3d& inverse_bind(std::size_t joint) const { return *inverse_bind_[joint]; }
  // The joint that a node is; nothing where it is none, or where no vertex follows it or a joint below it.
  std::optional<std::size_t> moving_joint(std::size_t node) const;

 private:
  using Map = Eigen::Affine3d;

  // A skin of the file.
  struct FileSkin {
    std::vector<std::size_t> nodes;     // of its joints; empty: not read yet
    std::vector<Map> inverses;          // inverse bind matrices
    std::vector<double> weights;        // of all vertices, by joint
    std::vector<std::uint32_t> joints;  // of joints_, by its own
    std::vector<double> sides;          // of its joints at rest: below 0 where one mirrors
    Map map = Map::Identity();          // from its meshes to the space of the character
  };

  void find_nodes(const std::vector<bool>& moving, bool without_skins);
  void add_node(std::size_t node);
  void add_weights();
  void read_skin(int index, FileSkin& skin) const;
  void place_skins();
  bool place_by_known(FileSkin& skin, const std::vector<std::size_t>& order) const;
  bool place_at_rest(FileSkin& skin, const std::vector<std::size_t>& order) const;
  void add_inverses(FileSkin& skin, double size);
  void complete_inverses();
  std::pair<int, Map> find_joint(std::size_t node, std::vector<std::optional<Map>>& to_joint);
  void place_unskinned();
  void fill_skin(const std::vector<std::vector<std::pair<std::uint32_t, float>>>& influences);

  const GltfFile& file_;
  const GltfScene& scene_;
  const std::vector<GltfMesh>& meshes_;
  UniqueNames names_;
  std::vector<int> joint_of_node_;                // -1: none
  std::vector<int> hangs_on_;                     // by node that is no joint, once it was asked for; -1: none
  std::vector<std::size_t> nodes_;                // of each joint
  std::vector<bool> repeats_;                     // of each joint
  std::vector<Map> locals_;                       // of each joint
  std::vector<bool> followed_;                    // of each joint: by vertices, or one below it is
  std::vector<std::optional<Map>> inverse_bind_;  // of each joint
  std::vector<FileSkin> skins_;                   // of the file
  std::vector<Map> maps_;
  std::vector<int> rigid_;  // by shown mesh: the joint that it follows alone, or -1
  std::vector<Joint> joints_;
  Skin skin_;
};

}  // namespace fb::bake
