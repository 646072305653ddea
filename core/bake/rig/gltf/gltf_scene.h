#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_file.h"
#include "bake/rig/gltf/left_out.h"
#include "base/status.h"

namespace tinygltf {
struct Node;
}  // namespace tinygltf

namespace fb::bake {

// The transform of a node, which applies scale, rotation and translation in this order.
struct NodeParts {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

Eigen::Affine3d place_of(const NodeParts& parts);
// Those of a node; nothing for a matrix that shears, or flattens.
std::optional<NodeParts> parts_of(const tinygltf::Node& node);

// A mesh where a node shows it. A mesh that two nodes show is two.
struct ShownMesh {
  std::string name;  // of the node, or of the mesh where that has none; unique
  std::size_t mesh;  // index in the file
  int node;          // -1: none, in a file without nodes
  int skin;          // -1: none
  // From the mesh to the node: of EXT_mesh_gpu_instancing the first instance.
  Eigen::Affine3d instance = Eigen::Affine3d::Identity();
};

// What refuses a mesh that cannot be read.
class BrokenMesh : public Error {
 public:
  BrokenMesh(const Error& reason, const std::string& mesh)
      : Error(reason.status(), "mesh \"" + mesh + "\": " + reason.what()), mesh_(mesh) {}
  const std::string& mesh() const { return mesh_; }  // its name

 private:
  std::string mesh_;
};

// Calls work(), which reads a mesh; an Error becomes a BrokenMesh.
template <class Work>
auto in_mesh(const ShownMesh& mesh, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw BrokenMesh(error, mesh.name);
  }
}

// The nodes of a glTF file and the meshes that they show.
class GltfScene {
 public:
  // Fails on nodes, meshes and skins that there are not, nodes with two parents, and nodes that are their own parents.
  // `broken`: names of meshes to leave out.
  GltfScene(const GltfFile& file, const std::set<std::string>& broken, LeftOut& left_out);

  // In the order of nodes: those of the default scene, or all where there is none. In a file without nodes, all meshes.
  // Meshes of other scenes, and instances besides the first, are left out, with notes.
  const std::vector<ShownMesh>& meshes() const { return meshes_; }
  // From a node to the scene.
  const Eigen::Affine3d& world(std::size_t node) const { return worlds_.at(node); }
  // From a node to its parent, or to the scene where it has none.
  const Eigen::Affine3d& local(std::size_t node) const { return locals_.at(node); }
  // -1: none.
  int parent(std::size_t node) const { return parents_.at(node); }

 private:
  void place_nodes(const GltfFile& file);
  void note_hidden(const GltfFile& file, const std::vector<bool>& shown, LeftOut& left_out) const;

  std::vector<Eigen::Affine3d> locals_, worlds_;
  std::vector<int> parents_;
  std::vector<ShownMesh> meshes_;
};

// Names that are told apart by numbers: "eye", "eye (2)", ...
class UniqueNames {
 public:
  std::string add(const std::string& name);

 private:
  std::map<std::string, int> next_;  // number of each name that is taken
};

}  // namespace fb::bake
