#include <facebaker/facebaker_character.h>

#include "abi_guard.h"
#include "base/shown_path.h"
#include "loaded_model.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

template <class Struct>
std::uint32_t count(const fb_model* model, std::vector<Struct> LoadedCharacter::*list) {
  return model ? static_cast<std::uint32_t>((model->character.*list).size()) : 0;
}

// Copies an element of a list to a caller's struct, up to its size. `what`: "mesh".
template <class Struct>
fb_status copy_at(const fb_model* model, std::vector<Struct> LoadedCharacter::*list, std::uint32_t index, Struct* to,
                  const char* what) {
  return abi_guard([&] {
    require(model, "model");
    require(to, what);
    require_size(to->struct_size, what);
    const std::vector<Struct>& all = model->character.*list;
    if (index >= all.size()) fail(Status::invalid_argument, "%s %u of %zu", what, index, all.size());
    Struct full = all[index];
    full.struct_size = to->struct_size;
    std::memcpy(static_cast<void*>(to), &full, std::min<std::size_t>(to->struct_size, sizeof full));
  });
}

// The index of the element of this name. `what`: "mesh".
template <class Struct>
fb_status find(const fb_model* model, std::vector<Struct> LoadedCharacter::*list, const char* name,
               std::uint32_t* index, const char* what) {
  return abi_guard([&] {
    constexpr std::size_t longest = 400;  // of the names there are, in the message
    require(model, "model");
    require(name, "name");
    require(index, "index");
    std::string names;
    const std::vector<Struct>& all = model->character.*list;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      if (std::strcmp(all[i].name, name) == 0) {
        *index = i;
        return;
      }
      if (names.size() < longest) names += fb::format("%s\"%s\"", i == 0 ? "" : ", ", fb::shown(all[i].name).c_str());
    }
    fail(Status::not_found, "there is no %s \"%s\"; there are %s", what, fb::shown(name).c_str(),
         names.empty() ? "none" : names.c_str());
  });
}

}  // namespace

void fb_mesh_fill(fb_mesh* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_mesh_count(const fb_model* model) {
  return count(model, &LoadedCharacter::meshes);
}

fb_status fb_mesh_at(const fb_model* model, uint32_t index, fb_mesh* mesh) {
  return copy_at(model, &LoadedCharacter::meshes, index, mesh, "fb_mesh");
}

fb_status fb_find_mesh(const fb_model* model, const char* name, uint32_t* index) {
  return find(model, &LoadedCharacter::meshes, name, index, "mesh");
}

void fb_material_fill(fb_material* to, uint32_t struct_size) {
  fb_material defaults = {};
  defaults.name = "";
  for (float& factor : defaults.base_colour) factor = 1;
  defaults.metallic = defaults.roughness = 1;
  defaults.alpha_cutoff = 0.5f;
  fill_struct(to, struct_size, defaults);
}

uint32_t fb_material_count(const fb_model* model) {
  return count(model, &LoadedCharacter::materials);
}

fb_status fb_material_at(const fb_model* model, uint32_t index, fb_material* material) {
  return copy_at(model, &LoadedCharacter::materials, index, material, "fb_material");
}

void fb_image_fill(fb_image* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_image_count(const fb_model* model) {
  return count(model, &LoadedCharacter::images);
}

fb_status fb_image_at(const fb_model* model, uint32_t index, fb_image* image) {
  return copy_at(model, &LoadedCharacter::images, index, image, "fb_image");
}

void fb_socket_fill(fb_socket* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_socket_count(const fb_model* model) {
  return count(model, &LoadedCharacter::sockets);
}

fb_status fb_socket_at(const fb_model* model, uint32_t index, fb_socket* socket) {
  return copy_at(model, &LoadedCharacter::sockets, index, socket, "fb_socket");
}

void fb_level_fill(fb_level* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_level_count(const fb_model* model) {
  return count(model, &LoadedCharacter::levels);
}

fb_status fb_level_at(const fb_model* model, uint32_t index, fb_level* level) {
  return copy_at(model, &LoadedCharacter::levels, index, level, "fb_level");
}

const char* fb_about(const fb_model* model) {
  return model ? model->character.about() : nullptr;
}

const void* fb_thumbnail(const fb_model* model, uint64_t* byte_count) {
  const std::span<const std::byte> png = model ? model->character.thumbnail() : std::span<const std::byte>();
  if (byte_count) *byte_count = png.size();
  return png.empty() ? nullptr : png.data();
}

fb_status fb_find_socket(const fb_model* model, const char* name, uint32_t* index) {
  return find(model, &LoadedCharacter::sockets, name, index, "socket");
}

void fb_channel_fill(fb_channel* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_channel_count(const fb_model* model) {
  return count(model, &LoadedCharacter::channels);
}

fb_status fb_channel_at(const fb_model* model, uint32_t index, fb_channel* channel) {
  return copy_at(model, &LoadedCharacter::channels, index, channel, "fb_channel");
}

fb_status fb_find_channel(const fb_model* model, const char* name, uint32_t* index) {
  return find(model, &LoadedCharacter::channels, name, index, "channel");
}

void fb_exact_pose_fill(fb_exact_pose* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_exact_pose_count(const fb_model* model) {
  return count(model, &LoadedCharacter::exact_poses);
}

fb_status fb_exact_pose_at(const fb_model* model, uint32_t index, fb_exact_pose* pose) {
  return copy_at(model, &LoadedCharacter::exact_poses, index, pose, "fb_exact_pose");
}

fb_status fb_exact_corrections(const fb_model* model, uint32_t index, uint32_t row_block, float* corrections,
                               uint32_t* corrects) {
  return abi_guard([&] {
    require(model, "model");
    const fb::runtime::ExactBlend& exact = model->evaluator.layout().exact;
    const auto blocks = model->evaluator.row_blocks();
    if (index >= exact.count()) fail(Status::invalid_argument, "exact pose %u of %zu", index, exact.count());
    if (row_block >= blocks.size()) fail(Status::invalid_argument, "row block %u of %zu", row_block, blocks.size());
    for (std::uint32_t row = 0; corrections && row < blocks[row_block].row_count(); ++row)
      corrections[row] = exact.correction(index, row_block, row);
    if (corrects) *corrects = exact.corrects(index, row_block);
  });
}

void fb_joint_fill(fb_joint* to, uint32_t struct_size) {
  fb_joint defaults = {};
  defaults.parent = FB_NO_JOINT;
  for (const std::size_t diagonal : {0, 5, 10}) defaults.rest[diagonal] = 1;
  fill_struct(to, struct_size, defaults);
}

uint32_t fb_joint_count(const fb_model* model) {
  return count(model, &LoadedCharacter::joints);
}

fb_status fb_joint_at(const fb_model* model, uint32_t index, fb_joint* joint) {
  return copy_at(model, &LoadedCharacter::joints, index, joint, "fb_joint");
}

fb_status fb_find_joint(const fb_model* model, const char* name, uint32_t* index) {
  return find(model, &LoadedCharacter::joints, name, index, "joint");
}

uint32_t fb_skin_influences(const fb_model* model) {
  return model ? model->character.skin().influences : 0;
}

const uint16_t* fb_skin_joints(const fb_model* model) {
  return fb_skin_influences(model) > 0 ? model->character.skin().joints.data() : nullptr;
}

const float* fb_skin_weights(const fb_model* model) {
  return fb_skin_influences(model) > 0 ? model->character.skin().weights.data() : nullptr;
}

void fb_driven_joint_fill(fb_driven_joint* to, uint32_t struct_size) {
  fb_driven_joint defaults = {};
  defaults.parent = FB_NO_JOINT;
  for (std::size_t axis = 0; axis < 3; ++axis) defaults.rest[5 * axis] = 1;
  fill_struct(to, struct_size, defaults);
}

uint32_t fb_driven_joint_count(const fb_model* model) {
  return count(model, &LoadedCharacter::driven_joints);
}

fb_status fb_driven_joint_at(const fb_model* model, uint32_t index, fb_driven_joint* joint) {
  return copy_at(model, &LoadedCharacter::driven_joints, index, joint, "fb_driven_joint");
}

fb_status fb_find_driven_joint(const fb_model* model, const char* name, uint32_t* index) {
  return find(model, &LoadedCharacter::driven_joints, name, index, "driven joint");
}

uint32_t fb_driven_influences(const fb_model* model) {
  return model ? model->character.driven_skin().influences : 0;
}

const uint16_t* fb_driven_skin_joints(const fb_model* model) {
  return fb_driven_influences(model) > 0 ? model->character.driven_skin().joints.data() : nullptr;
}

const float* fb_driven_skin_weights(const fb_model* model) {
  return fb_driven_influences(model) > 0 ? model->character.driven_skin().weights.data() : nullptr;
}
