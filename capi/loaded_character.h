// Meshes, materials, images, sockets, channels and joints of a loaded face, as hosts see them.
#pragma once

#include <facebaker/facebaker_character.h>

#include <span>
#include <vector>

#include "base/memory_budget.h"
#include "model/packed_model.h"

namespace fb::capi {

class LoadedCharacter {
 public:
  // Takes names and images out of the model, whose memory is charged already; what is made here is charged to `budget`.
  LoadedCharacter(PackedModel& model, MemoryBudget& budget);
  // The structs point into it.
  LoadedCharacter(const LoadedCharacter&) = delete;
  LoadedCharacter& operator=(const LoadedCharacter&) = delete;

  std::vector<fb_mesh> meshes;
  std::vector<fb_material> materials;
  std::vector<fb_image> images;
  std::vector<fb_socket> sockets;
  std::vector<fb_channel> channels;
  std::vector<fb_exact_pose> exact_poses;
  std::vector<fb_joint> joints;
  std::vector<fb_driven_joint> driven_joints;
  std::vector<fb_level> levels;  // the whole first; its polygons are set by use_polygons()

  // Says where the polygons of the whole lie, for level 0.
  void use_polygons(const Mesh& rest, const std::uint32_t* sizes, const std::uint32_t* corners,
                    const std::uint32_t* uv_corners);

  const char* about() const { return character_.about.c_str(); }
  std::span<const std::byte> thumbnail() const { return character_.thumbnail; }
  const Skin& skin() const { return character_.skin; }
  const Skin& driven_skin() const { return driven_.skin; }

 private:
  void describe_meshes(const Mesh& rest);
  void describe_levels(const PackedModel& model);
  void describe_materials();
  void describe_joints();
  void describe_exact_poses();

  std::vector<MeshPart> parts_;
  std::vector<Channel> channels_;
  std::vector<ExactPose> exact_;  // without values
  Character character_;
  DrivenJoints driven_;
  std::vector<fb_material_run> runs_;
  std::vector<fb_texture> textures_;
  std::vector<DetailLevel> levels_;    // coarser ones
  std::vector<fb_mesh> level_meshes_;  // of each
};

}  // namespace fb::capi
