#pragma once

#include <facebaker/facebaker_character.h>
#include <facebaker/facebaker.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/mesh_view.h"

namespace fb::tool {

// Everything of a face that files of other programs hold, borrowed from its model.
struct CharacterView {
  std::string name;
  std::string units;    // see metres_per
  std::string up_axis;  // "y" or "z"
  MeshView mesh;        // the pool: all meshes
  std::vector<fb_mesh> meshes;
  std::vector<fb_material> materials;
  std::vector<fb_image> images;
  std::vector<fb_socket> sockets;
  std::vector<fb_joint> joints;
  std::uint32_t influences = 0;                // of a vertex of the skin; 0: none
  std::span<const std::uint16_t> skin_joints;  // vertices x influences
  std::span<const float> skin_weights;
  std::vector<fb_driven_joint> driven_joints;
  std::uint32_t driven_influences = 0;                // likewise, of driven joints
  std::span<const std::uint16_t> driven_skin_joints;  // vertices x influences
  std::span<const float> driven_skin_weights;

  // lod: a level of detail, whose polygons are those of the level that it is rounded down to.
  explicit CharacterView(const facebaker::Model& model, float lod = 0);

  // The name of a mesh; the character's if it has none.
  std::string mesh_name(std::size_t index) const;
  // The part of `vectors` (3 x vertices of the pool) that belongs to a mesh.
  std::span<const float> part(std::size_t index, std::span<const float> vectors) const;
};

// The pool of a model.
MeshView mesh_of(const facebaker::Model& model);

// One mesh of a character by itself.
class SingleMesh {
 public:
  SingleMesh(const CharacterView& character, std::size_t index);
  SingleMesh(const SingleMesh&) = delete;
  SingleMesh& operator=(const SingleMesh&) = delete;

  // With vertices counted from the mesh's first, and the texture coordinates of the pool. Lives as long as this.
  const MeshView& view() const { return view_; }

 private:
  std::vector<std::uint32_t> corners_;
  MeshView view_;
};

}  // namespace fb::tool
