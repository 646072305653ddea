#include "export/glb_meshes.h"

#include "export/glb_materials.h"
#include "export/glb_skin.h"
#include "export/morph_normals.h"
#include "export/uv_seams.h"
#include "export/valid_utf8.h"

namespace fb::tool {
namespace {

using Attributes = std::map<std::string, int>;

Attributes vertices_of(GlbBuffer& buffer, const SplitMesh& split, std::span<const float> points,
                       std::span<const float> normals) {
  Attributes attributes;
  attributes["POSITION"] = buffer.vectors(split.with_copies(points), 3);
  if (!split.triangles.empty()) attributes["NORMAL"] = buffer.vectors(split.with_copies(normals), 3);
  if (!split.uvs.empty()) {
    std::vector<float> uvs = split.uvs;
    for (std::size_t i = 1; i < uvs.size(); i += 2) uvs[i] = 1 - uvs[i];  // in glTF v grows downwards
    attributes["TEXCOORD_0"] = buffer.vectors(uvs, 2);
  }
  return attributes;
}

std::vector<Attributes> targets_of(GlbBuffer& buffer, const SplitMesh& split, const MorphTargets& morph) {
  std::vector<Attributes> targets;
  for (std::size_t t = 0; t < morph.count; ++t) {
    Attributes attributes;
    attributes["POSITION"] = buffer.displacements(split.with_copies(morph.target(t)));
    if (!split.triangles.empty())
      attributes["NORMAL"] = buffer.displacements(split.with_copies(morph.target_normals(t)));
    targets.push_back(std::move(attributes));
  }
  return targets;
}

// One primitive for each run of polygons.
void add_primitives(tinygltf::Mesh& mesh, GlbBuffer& buffer, const CharacterView& character, const fb_mesh& from,
                    const MeshView& view, const SplitMesh& split, const tinygltf::Primitive& shared) {
  std::size_t polygon = 0, first = 0;
  for (const fb_material_run& run : std::span(from.runs, from.run_count)) {
    std::size_t corners = 0;
    for (std::uint32_t p = 0; p < run.polygon_count; ++p, ++polygon) corners += 3 * (view.polygon_sizes[polygon] - 2);
    tinygltf::Primitive primitive = shared;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = material_of(character, run);
    primitive.indices = buffer.indices(std::span(split.triangles).subspan(first, corners));
    mesh.primitives.push_back(primitive);
    first += corners;
  }
}

}  // namespace

void add_mesh(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character, std::size_t index,
              std::span<const float> points, const MorphTargets& morph) {
  const SingleMesh single(character, index);
  const MeshView& view = single.view();
  const SplitMesh split = split_at_seams(view);
  const std::vector<float> normals = unit_normals(view.triangles(), points);
  tinygltf::Mesh mesh;
  mesh.name = valid_utf8(character.mesh_name(index));
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_POINTS;
  primitive.attributes = vertices_of(buffer, split, points, normals);
  if (is_skinned(character, index)) add_influences(model, primitive.attributes, buffer, character, index, split);
  primitive.targets = targets_of(buffer, split, morph);
  if (view.polygon_sizes.empty())
    mesh.primitives.push_back(primitive);
  else
    add_primitives(mesh, buffer, character, character.meshes[index], view, split, primitive);
  for (std::size_t t = 0; t < morph.count; ++t) mesh.weights.push_back(morph.weights[t]);
  if (!morph.names.empty()) {
    tinygltf::Value::Array names;
    for (const std::string& name : morph.names) names.emplace_back(valid_utf8(name));
    mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
  }
  model.meshes.push_back(mesh);
}

}  // namespace fb::tool
