#include "loaded_character.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace fb::capi {

LoadedCharacter::LoadedCharacter(PackedModel& model, MemoryBudget& budget)
    : parts_(std::move(model.rest.parts)),
      channels_(std::move(model.schema.channels)),
      exact_(std::move(model.exact)),
      character_(std::move(model.character)),
      driven_(std::move(model.rest.driven)),
      levels_(std::move(model.levels)) {
  if (parts_.empty()) {
    const auto vertices = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
    const auto polygons = static_cast<std::uint32_t>(model.rest.polygon_sizes.size());
    parts_ = {{"", vertices, polygons}};
    if (polygons > 0) parts_[0].materials = {{polygons, no_material}};
  }
  std::size_t runs = 0, textures = 0;
  for (const MeshPart& part : parts_) runs += part.materials.size();
  for (const DetailLevel& level : levels_)
    for (const LevelPart& part : level.parts) runs += part.materials.size();
  runs += levels_.size();  // of the one mesh of a face that names none
  for (const Material& material : character_.materials) textures += material.textures.size();
  budget.reserve(meshes, parts_.size(), "meshes");
  budget.reserve(runs_, runs, "material runs");
  budget.reserve(materials, character_.materials.size(), "materials");
  budget.reserve(textures_, textures, "textures");
  budget.reserve(images, character_.images.size(), "images");
  budget.reserve(sockets, character_.sockets.size(), "sockets");
  budget.reserve(channels, channels_.size(), "channels");
  budget.reserve(exact_poses, exact_.size(), "exact poses");
  budget.reserve(joints, character_.joints.size(), "joints");
  budget.reserve(driven_joints, driven_.joints.size(), "driven joints");
  budget.reserve(levels, levels_.size() + 1, "levels");
  budget.reserve(level_meshes_, levels_.size() * parts_.size(), "levels");
  describe_meshes(model.rest);
  describe_materials();
  describe_levels(model);
  for (const Image& image : character_.images)
    images.push_back(
        {sizeof(fb_image), 0, image.name.c_str(), image.media_type.c_str(), image.bytes.data(), image.bytes.size()});
  for (const Socket& from : character_.sockets) {
    fb_socket& socket = sockets.emplace_back(fb_socket{sizeof(fb_socket),
                                                       static_cast<std::uint32_t>(from.vertices.size()),
                                                       from.name.c_str(),
                                                       from.vertices.data(),
                                                       from.weights.data(),
                                                       {}});
    std::copy(std::begin(from.frame), std::end(from.frame), socket.frame);
  }
  for (const Channel& from : channels_)
    channels.push_back(
        {sizeof(fb_channel), 0, from.name.c_str(), from.unit.c_str(), from.minimum, from.maximum, from.rest});
  describe_joints();
  describe_exact_poses();
}

void LoadedCharacter::describe_joints() {
  for (const Joint& from : character_.joints) {
    fb_joint& joint = joints.emplace_back(fb_joint{sizeof(fb_joint), from.parent, from.name.c_str(), {}, {}});
    std::copy(std::begin(from.rest), std::end(from.rest), joint.rest);
    std::copy(std::begin(from.inverse_bind), std::end(from.inverse_bind), joint.inverse_bind);
  }
  for (const DrivenJoint& from : driven_.joints) {
    const auto outer = static_cast<std::uint32_t>(from.outer_rotations.size());
    fb_driven_joint& joint = driven_joints.emplace_back(
        fb_driven_joint{sizeof(fb_driven_joint), from.parent, from.name.c_str(), from.numbers, outer, {}});
    std::copy(std::begin(from.rest), std::end(from.rest), joint.rest);
  }
}

void LoadedCharacter::describe_exact_poses() {
  for (ExactPose& from : exact_) {
    std::vector<std::int32_t>().swap(from.values);  // evaluation has its own
    exact_poses.push_back({sizeof(fb_exact_pose), static_cast<std::uint32_t>(from.controls.size()), from.name.c_str(),
                           from.controls.data()});
  }
}

void LoadedCharacter::describe_meshes(const Mesh& rest) {
  fb_mesh mesh = {};
  mesh.struct_size = sizeof mesh;
  for (const MeshPart& part : parts_) {
    mesh.name = part.name.c_str();
    mesh.runs = runs_.data() + runs_.size();
    mesh.run_count = static_cast<std::uint32_t>(part.materials.size());
    for (const MaterialRun& run : part.materials) runs_.push_back({run.polygons, run.material});
    mesh.vertex_count = part.vertices;
    mesh.polygon_count = part.polygons;
    mesh.corner_count = 0;
    for (std::uint32_t p = 0; p < part.polygons; ++p) mesh.corner_count += rest.polygon_sizes[mesh.first_polygon + p];
    meshes.push_back(mesh);
    mesh.first_vertex += part.vertices;
    mesh.first_polygon += part.polygons;
    mesh.first_corner += mesh.corner_count;
  }
}

void LoadedCharacter::describe_levels(const PackedModel& model) {
  const auto surface = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  levels.push_back({sizeof(fb_level), surface, 0, 0, nullptr, nullptr, nullptr, meshes.data(), model.columns, 0});
  for (const DetailLevel& from : levels_) {
    fb_mesh mesh = {};
    mesh.struct_size = sizeof mesh;
    const fb_mesh* const first = level_meshes_.data() + level_meshes_.size();
    for (std::size_t m = 0; m < parts_.size(); ++m) {
      const auto polygons = static_cast<std::uint32_t>(from.polygon_sizes.size());
      const LevelPart whole{
          polygons, polygons > 0 ? std::vector{MaterialRun{polygons, no_material}} : std::vector<MaterialRun>()};
      const LevelPart& part = from.parts.empty() ? whole : from.parts[m];
      mesh.name = meshes[m].name;
      mesh.first_vertex = meshes[m].first_vertex;
      mesh.vertex_count = meshes[m].vertex_count;
      mesh.polygon_count = part.polygons;
      mesh.runs = runs_.data() + runs_.size();
      mesh.run_count = static_cast<std::uint32_t>(part.materials.size());
      for (const MaterialRun& run : part.materials) runs_.push_back({run.polygons, run.material});
      mesh.corner_count = 0;
      for (std::uint32_t p = 0; p < part.polygons; ++p) mesh.corner_count += from.polygon_sizes[mesh.first_polygon + p];
      level_meshes_.push_back(mesh);
      mesh.first_polygon += part.polygons;
      mesh.first_corner += mesh.corner_count;
    }
    levels.push_back({sizeof(fb_level), from.vertices, static_cast<std::uint32_t>(from.polygon_sizes.size()),
                      static_cast<std::uint32_t>(from.polygon_corners.size()), from.polygon_sizes.data(),
                      from.polygon_corners.data(), from.uv_corners.empty() ? nullptr : from.uv_corners.data(), first,
                      static_cast<std::uint32_t>(coefficients_of(model, from)), 0});
  }
}

void LoadedCharacter::use_polygons(const Mesh& rest, const std::uint32_t* sizes, const std::uint32_t* corners,
                                   const std::uint32_t* uv_corners) {
  levels[0].polygon_count = static_cast<std::uint32_t>(rest.polygon_sizes.size());
  levels[0].corner_count = static_cast<std::uint32_t>(rest.polygon_corners.size());
  levels[0].polygon_sizes = sizes;
  levels[0].polygon_corners = corners;
  levels[0].uv_corners = rest.uv_corners.empty() ? nullptr : uv_corners;
}

void LoadedCharacter::describe_materials() {
  for (const Material& from : character_.materials) {
    fb_material material = {};
    material.struct_size = sizeof material;
    material.alpha_mode = static_cast<std::uint32_t>(from.alpha_mode);
    material.name = from.name.c_str();
    std::copy(std::begin(from.base_colour), std::end(from.base_colour), material.base_colour);
    material.metallic = from.metallic;
    material.roughness = from.roughness;
    std::copy(std::begin(from.emissive), std::end(from.emissive), material.emissive);
    material.alpha_cutoff = from.alpha_cutoff;
    material.double_sided = from.double_sided;
    material.texture_count = static_cast<std::uint32_t>(from.textures.size());
    material.textures = from.textures.empty() ? nullptr : textures_.data() + textures_.size();
    for (const Texture& texture : from.textures)
      textures_.push_back({static_cast<std::uint32_t>(texture.slot), texture.image,
                           static_cast<std::uint32_t>(texture.wrap_u), static_cast<std::uint32_t>(texture.wrap_v),
                           texture.scale});
    materials.push_back(material);
  }
}

}  // namespace fb::capi
