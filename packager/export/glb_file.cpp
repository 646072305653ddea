#include "export/glb_file.h"

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "export/file_stream.h"
#include "export/glb_animation.h"
#include "export/glb_materials.h"
#include "export/glb_meshes.h"
#include "export/glb_skin.h"
#include "export/node_transform.h"
#include "export/valid_utf8.h"

namespace fb::tool {
namespace {

int add_node(tinygltf::Model& model, const tinygltf::Node& node) {
  model.nodes.push_back(node);
  return static_cast<int>(model.nodes.size()) - 1;
}

// The upper node, scaled and turned to glTF's metres and y up.
void add_root(tinygltf::Model& model, const CharacterView& character) {
  tinygltf::Node node;
  node.name = valid_utf8(character.name);
  node.scale.assign(3, metres_per(character.units).value_or(1));
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
  const NodeTransform transform(std::span(scene.socket_frames).subspan(12 * socket, 12));
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

// frames: of all joints, in their parents. Joints that stay at rest have no channels.
void animate_joints(GlbAnimation& animation, const CharacterView& character, const std::vector<int>& joints,
                    std::span<const float> frames) {
  const std::size_t count = joints.size();
  for (std::size_t j = 0; j < count && !frames.empty(); ++j) {
    const std::span rest(character.joints[j].rest);
    bool moves = false;
    for (std::size_t first = 12 * j; first < frames.size() && !moves; first += 12 * count)
      moves = !std::ranges::equal(frames.subspan(first, 12), rest);
    if (moves) animation.add_frames(joints[j], frames, j, count);
  }
}

// Puts joints where they are in the first frame, and animates them where there are more.
void add_tracks(tinygltf::Model& model, GlbAnimation& animation, const GlbScene& scene,
                const std::vector<int>& joints) {
  const auto set = [](std::vector<double>& part, const std::vector<float>& values, std::ptrdiff_t width) {
    if (!values.empty()) part.assign(values.begin(), values.begin() + width);
  };
  for (const auto& [moved, track] : scene.tracks) {
    std::vector<int> nodes;
    for (const std::uint32_t joint : moved) {
      nodes.push_back(joints[joint]);
      tinygltf::Node& node = model.nodes[static_cast<std::size_t>(joints[joint])];
      set(node.translation, track.translations, 3);
      set(node.rotation, track.rotations, 4);
      set(node.scale, track.scales, 3);
    }
    if (scene.frames > 1) animation.add_track(nodes, track);
  }
}

void add_extras(tinygltf::Model& model, const GlbScene& scene) {
  tinygltf::Value::Object extras;
  for (const auto& [name, text] : scene.texts) extras[name] = tinygltf::Value(valid_utf8(text));
  for (const auto& [name, figure] : scene.figures) extras[name] = tinygltf::Value(figure);
  if (!extras.empty()) model.asset.extras = tinygltf::Value(extras);
}

void add_scene(tinygltf::Model& model, GlbBuffer& buffer, const GlbScene& scene, std::vector<std::string>& notes) {
  const CharacterView& character = scene.character;
  GlbAnimation animation(model, buffer, scene.frames, scene.fps);
  add_root(model, character);
  const std::vector<int> joints = add_joints(model, buffer, character);
  std::vector<int> mesh_nodes;
  for (std::size_t m = 0; m < character.meshes.size(); ++m) {
    add_mesh(model, buffer, character, m, character.part(m, scene.points), scene.morphs[m]);
    const int node = add_mesh_node(model, character, m);
    mesh_nodes.push_back(node);
    if (scene.frames > 1 && scene.morphs[m].count > 0) animation.add_weights(node, scene.morphs[m].weights);
  }
  for (std::size_t s = 0; s < character.sockets.size(); ++s) {
    const int node = add_socket_node(model, scene, s, notes);
    if (scene.frames > 1) animation.add_frames(node, scene.socket_frames, s, character.sockets.size());
  }
  if (scene.frames > 1) animate_joints(animation, character, joints, scene.joint_frames);
  add_tracks(model, animation, scene, joints);
  animation.finish(character.name);
  for (const JointAnimation& more : scene.more) {
    GlbAnimation one(model, buffer, 2, 1);
    animate_joints(one, character, joints, more.joint_frames);
    for (std::size_t m = 0; m < mesh_nodes.size(); ++m)
      if (scene.morphs[m].count > 0 && std::ranges::any_of(more.weights[m], [](float w) { return w != 0; }))
        one.add_weights(mesh_nodes[m], more.weights[m]);
    one.finish(more.name);
  }
}

}  // namespace

std::vector<std::string> write_glb(const std::filesystem::path& path, const GlbScene& scene) {
  std::vector<std::string> notes;
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "FaceBaker " FB_VERSION;
  add_extras(model, scene);
  GlbBuffer buffer(model);
  add_scene(model, buffer, scene, notes);
  add_materials(model, buffer, scene.character, notes);

  // A .glb counts its bytes in 32 bits.
  if (model.buffers[0].data.size() > 0xf0000000u)
    fail(Status::limit, "%s: %zu bytes are more than a .glb holds; write fewer frames, or with a larger --tolerance",
         shown(path).c_str(), model.buffers[0].data.size());
  AtomicFile file(path);
  FileStream stream(file);
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true))
    fail(Status::internal, "%s: tinygltf refused to write it", shown(path).c_str());
  file.commit();
  return notes;
}

}  // namespace fb::tool
