#include "export/glb_file.h"

#include <cmath>
#include <map>
#include <sstream>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "export/glb_animation.h"
#include "export/glb_materials.h"
#include "export/glb_meshes.h"
#include "export/glb_skin.h"
#include "export/socket_transform.h"
#include "export/valid_utf8.h"

namespace fb::tool {
namespace {

double metres(const std::string& units) {
  static const std::map<std::string, double> table = {
      {"mm", 0.001}, {"cm", 0.01}, {"dm", 0.1}, {"in", 0.0254}, {"ft", 0.3048}};
  const auto found = table.find(units);
  return found == table.end() ? 1.0 : found->second;
}

int add_node(tinygltf::Model& model, const tinygltf::Node& node) {
  model.nodes.push_back(node);
  return static_cast<int>(model.nodes.size()) - 1;
}

// The upper node, scaled and turned to glTF's metres and y up.
void add_root(tinygltf::Model& model, const CharacterView& character) {
  tinygltf::Node node;
  node.name = valid_utf8(character.name);
  node.scale.assign(3, metres(character.units));
  if (character.up_axis == "z") node.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  model.scenes.emplace_back();
  model.scenes[0].nodes.push_back(add_node(model, node));
  model.defaultScene = 0;
}

// Gives the node of a mesh.
int add_mesh_node(tinygltf::Model& model, const CharacterView& character, std::size_t mesh) {
  tinygltf::Node node;
  node.name = valid_utf8(character.mesh_name(mesh));
  node.mesh = static_cast<int>(mesh);
  if (is_skinned(character, mesh)) {  // its node's transform has no effect
    node.skin = 0;
    const int index = add_node(model, node);
    model.scenes[0].nodes.push_back(index);
    return index;
  }
  if (!*character.meshes[mesh].name) {
    model.nodes[0].mesh = node.mesh;
    return 0;
  }
  const int index = add_node(model, node);
  model.nodes[0].children.push_back(index);
  return index;
}

// Gives the node of a socket, as it is in the first frame.
int add_socket_node(tinygltf::Model& model, const GlbScene& scene, std::size_t socket,
                    std::vector<std::string>& notes) {
  const std::string name = scene.character.sockets[socket].name;
  const SocketTransform transform(std::span(scene.socket_frames).subspan(12 * socket, 12));
  if (transform.sheared)
    notes.push_back(
        format("socket \"%s\": its frame is sheared; its axes are put at right angles", shown(name).c_str()));
  tinygltf::Node node;
  node.name = valid_utf8(name);
  node.translation.assign(transform.translation.begin(), transform.translation.end());
  node.rotation.assign(transform.rotation.begin(), transform.rotation.end());
  node.scale.assign(transform.scale.begin(), transform.scale.end());
  const int index = add_node(model, node);
  model.nodes[0].children.push_back(index);
  return index;
}

void add_scene(tinygltf::Model& model, GlbBuffer& buffer, const GlbScene& scene, std::vector<std::string>& notes) {
  const CharacterView& character = scene.character;
  GlbAnimation animation(model, buffer, scene.frames, scene.fps);
  add_root(model, character);
  add_joints(model, buffer, character);
  for (std::size_t m = 0; m < character.meshes.size(); ++m) {
    add_mesh(model, buffer, character, m, character.part(m, scene.points), scene.morphs[m]);
    const int node = add_mesh_node(model, character, m);
    if (scene.frames > 1 && scene.morphs[m].count > 0) animation.add_weights(node, scene.morphs[m].weights);
  }
  for (std::size_t s = 0; s < character.sockets.size(); ++s) {
    const int node = add_socket_node(model, scene, s, notes);
    if (scene.frames > 1) animation.add_socket(node, scene.socket_frames, s, character.sockets.size());
  }
  animation.finish(character.name);
}

}  // namespace

std::vector<std::string> write_glb(const std::filesystem::path& path, const GlbScene& scene) {
  std::vector<std::string> notes;
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "FaceBaker " FB_VERSION;
  GlbBuffer buffer(model);
  add_scene(model, buffer, scene, notes);
  add_materials(model, buffer, scene.character, notes);

  // A .glb counts its bytes in 32 bits.
  if (model.buffers[0].data.size() > 0xf0000000u)
    fail(Status::limit, "%s: %zu bytes are more than a .glb holds; write fewer frames, or with a larger --tolerance",
         shown(path).c_str(), model.buffers[0].data.size());
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true))
    fail(Status::internal, "%s: tinygltf refused to write it", shown(path).c_str());
  write_file(path, stream.str());
  return notes;
}

}  // namespace fb::tool
