#include "export/character_view.h"

#include <algorithm>

namespace fb::tool {
namespace {

// All structs of one kind that a model gives.
template <class T>
std::vector<T> all_of(const fb_model* model, std::uint32_t count, void (*fill)(T*, std::uint32_t),
                      fb_status (*get)(const fb_model*, std::uint32_t, T*)) {
  std::vector<T> all(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    fill(&all[i], sizeof(T));
    facebaker::check(get(model, i, &all[i]));
  }
  return all;
}

}  // namespace

MeshView mesh_of(const facebaker::Model& model) {
  const fb_model* m = model.get();
  const std::size_t corners = fb_polygon_corner_count(m);
  MeshView mesh = {{fb_rest_positions(m), 3 * std::size_t(fb_vertex_count(m))},
                   {fb_polygon_sizes(m), fb_polygon_count(m)},
                   {fb_polygon_corners(m), corners}};
  if (fb_uv_count(m) > 0) {
    mesh.uvs = {fb_uvs(m), 2 * std::size_t(fb_uv_count(m))};
    mesh.uv_corners = {fb_uv_corners(m), corners};
  }
  return mesh;
}

CharacterView::CharacterView(const facebaker::Model& model, float lod) : mesh(mesh_of(model)) {
  const fb_model* m = model.get();
  name = fb_name(m);
  units = fb_units(m);
  up_axis = fb_up_axis(m);
  meshes = all_of(m, fb_mesh_count(m), fb_mesh_fill, fb_mesh_at);
  if (lod >= 1) {
    fb_level level;
    fb_level_init(&level);
    const float last = static_cast<float>(fb_level_count(m) - 1);
    facebaker::check(fb_level_at(m, static_cast<std::uint32_t>(std::min(lod, last)), &level));
    mesh.polygon_sizes = {level.polygon_sizes, level.polygon_count};
    mesh.polygon_corners = {level.polygon_corners, level.corner_count};
    if (level.uv_corners) mesh.uv_corners = {level.uv_corners, level.corner_count};
    meshes.assign(level.meshes, level.meshes + meshes.size());
  }
  materials = all_of(m, fb_material_count(m), fb_material_fill, fb_material_at);
  images = all_of(m, fb_image_count(m), fb_image_fill, fb_image_at);
  sockets = all_of(m, fb_socket_count(m), fb_socket_fill, fb_socket_at);
  joints = all_of(m, fb_joint_count(m), fb_joint_fill, fb_joint_at);
  influences = fb_skin_influences(m);
  const std::size_t places = std::size_t(influences) * fb_vertex_count(m);
  skin_joints = {fb_skin_joints(m), places};
  skin_weights = {fb_skin_weights(m), places};
  driven_joints = all_of(m, fb_driven_joint_count(m), fb_driven_joint_fill, fb_driven_joint_at);
  driven_influences = fb_driven_influences(m);
  const std::size_t driven_places = std::size_t(driven_influences) * fb_vertex_count(m);
  driven_skin_joints = {fb_driven_skin_joints(m), driven_places};
  driven_skin_weights = {fb_driven_skin_weights(m), driven_places};
}

std::string CharacterView::mesh_name(std::size_t index) const {
  return *meshes[index].name ? meshes[index].name : name;
}

std::span<const float> CharacterView::part(std::size_t index, std::span<const float> vectors) const {
  return vectors.subspan(3 * std::size_t(meshes[index].first_vertex), 3 * std::size_t(meshes[index].vertex_count));
}

SingleMesh::SingleMesh(const CharacterView& character, std::size_t index) {
  const fb_mesh& mesh = character.meshes[index];
  const MeshView& pool = character.mesh;
  const auto corners = pool.polygon_corners.subspan(mesh.first_corner, mesh.corner_count);
  for (const std::uint32_t corner : corners) corners_.push_back(corner - mesh.first_vertex);
  view_ = {character.part(index, pool.points), pool.polygon_sizes.subspan(mesh.first_polygon, mesh.polygon_count),
           corners_};
  if (pool.uvs.empty() || corners.empty()) return;
  view_.uvs = pool.uvs;
  view_.uv_corners = pool.uv_corners.subspan(mesh.first_corner, mesh.corner_count);
}

}  // namespace fb::tool
