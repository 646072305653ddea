#include <facebaker/facebaker_character.h>

#include "abi_guard.h"
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
  return abi_guard([&] {
    require(model, "model");
    require(name, "name");
    require(index, "index");
    std::string names;
    const std::vector<fb_mesh>& meshes = model->character.meshes;
    for (std::uint32_t m = 0; m < meshes.size(); ++m) {
      if (std::strcmp(meshes[m].name, name) == 0) {
        *index = m;
        return;
      }
      if (names.size() < 400) names += fb::format("%s\"%s\"", m == 0 ? "" : ", ", meshes[m].name);
    }
    fail(Status::not_found, "no mesh is named \"%s\"; there are %s", name, names.c_str());
  });
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
