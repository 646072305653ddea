#include "export/glb_file.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

#include "base/checked.h"
#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "base/surface.h"
#include "export/uv_seams.h"

namespace fb::tool {
namespace {

// Appends arrays to the one buffer of a .glb, with their views and accessors.
class BufferWriter {
 public:
  explicit BufferWriter(tinygltf::Model& model) : model_(model) { model_.buffers.emplace_back(); }

  template <class T>
  int view(std::span<const T> values, int target) {
    auto& data = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = values.size_bytes();
    view.target = target;
    data.resize((data.size() + values.size_bytes() + 3) / 4 * 4);  // accessors begin at multiples of four bytes
    if (!values.empty()) std::memcpy(data.data() + view.byteOffset, values.data(), values.size_bytes());
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  int scalars(std::span<const float> values) {
    tinygltf::Accessor accessor = accessor_of(values, 1);
    accessor.bufferView = view(values, 0);
    return add(accessor);
  }

  int vectors(std::span<const float> values, int width = 3) {
    tinygltf::Accessor accessor = accessor_of(values, width);
    accessor.bufferView = view(values, TINYGLTF_TARGET_ARRAY_BUFFER);
    return add(accessor);
  }

  // Vectors; sparse if less than half of them are not zero.
  int displacements(std::span<const float> values) {
    std::vector<std::uint32_t> indices;
    std::vector<float> nonzero;
    for (std::size_t v = 0; v < values.size() / 3; ++v) {
      const auto vector = values.subspan(3 * v, 3);
      if (vector[0] == 0 && vector[1] == 0 && vector[2] == 0) continue;
      indices.push_back(static_cast<std::uint32_t>(v));
      nonzero.insert(nonzero.end(), vector.begin(), vector.end());
    }
    if (indices.empty() || indices.size() > values.size() / 6) return vectors(values);
    tinygltf::Accessor accessor = accessor_of(values, 3);
    accessor.sparse.isSparse = true;
    accessor.sparse.count = static_cast<int>(indices.size());
    accessor.sparse.indices.bufferView = view(std::span<const std::uint32_t>(indices), 0);
    accessor.sparse.indices.byteOffset = 0;
    accessor.sparse.indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.sparse.values.bufferView = view(std::span<const float>(nonzero), 0);
    accessor.sparse.values.byteOffset = 0;
    return add(accessor);
  }

  int indices(std::span<const std::uint32_t> values) {
    tinygltf::Accessor accessor;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = TINYGLTF_TYPE_SCALAR;
    accessor.count = values.size();
    accessor.bufferView = view(values, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    return add(accessor);
  }

 private:
  static tinygltf::Accessor accessor_of(std::span<const float> values, int width) {
    tinygltf::Accessor accessor;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = width == 3 ? TINYGLTF_TYPE_VEC3 : width == 2 ? TINYGLTF_TYPE_VEC2 : TINYGLTF_TYPE_SCALAR;
    accessor.count = values.size() / width;
    accessor.minValues.assign(width, INFINITY);
    accessor.maxValues.assign(width, -INFINITY);
    for (std::size_t i = 0; i < values.size(); ++i) {
      double &low = accessor.minValues[i % width], &high = accessor.maxValues[i % width];
      low = std::min(low, double(values[i]));
      high = std::max(high, double(values[i]));
    }
    return accessor;
  }

  int add(const tinygltf::Accessor& accessor) {
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  tinygltf::Model& model_;
};

std::vector<float> unit_normals(std::span<const std::uint32_t> triangles, std::span<const float> points) {
  std::vector<float> normals;
  for (Vector3 n : vertex_normals(triangles, points)) {
    if (!(length(n) > 0)) n = {0, 0, 1};  // a vertex without a polygon; glTF requires unit length
    normals.insert(normals.end(), {n.x, n.y, n.z});
  }
  return normals;
}

// Change of the normals for one unit of a target's weight, measured at the target's largest weight.
std::vector<float> normal_displacements(std::span<const std::uint32_t> triangles, std::span<const float> base,
                                        std::span<const float> base_normals, std::span<const float> target,
                                        float weight) {
  std::vector<float> moved(base.begin(), base.end());
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += weight * target[i];
  std::vector<float> normals = unit_normals(triangles, moved);
  for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = (normals[i] - base_normals[i]) / weight;
  return normals;
}

float largest_weight(const MorphAnimation& animation, std::size_t target) {
  float largest = 0;
  for (std::size_t f = 0; f < animation.frames(); ++f) {
    const float weight = animation.weights[f * animation.targets.size() + target];
    if (std::fabs(weight) > std::fabs(largest)) largest = weight;
  }
  return largest;
}

double metres(const std::string& units) {
  static const std::map<std::string, double> table = {
      {"mm", 0.001}, {"cm", 0.01}, {"dm", 0.1}, {"in", 0.0254}, {"ft", 0.3048}};
  const auto found = table.find(units);
  return found == table.end() ? 1.0 : found->second;
}

void add_animation(tinygltf::Model& model, BufferWriter& buffer, const GlbScene& scene,
                   std::span<const std::uint32_t> triangles, std::span<const float> normals, const SplitMesh& split) {
  const MorphAnimation& animation = scene.animation;
  tinygltf::Mesh& mesh = model.meshes[0];
  for (std::size_t t = 0; t < animation.targets.size(); ++t) {
    std::map<std::string, int> attributes = {
        {"POSITION", buffer.displacements(split.with_copies(animation.targets[t]))}};
    const float weight = largest_weight(animation, t);
    attributes["NORMAL"] = buffer.displacements(split.with_copies(
        weight != 0 ? normal_displacements(triangles, scene.base, normals, animation.targets[t], weight)
                    : std::vector<float>(scene.base.size())));
    mesh.primitives[0].targets.push_back(std::move(attributes));
    mesh.weights.push_back(animation.weights[t]);
  }
  std::vector<float> times;
  for (std::size_t f = 0; f < animation.frames(); ++f) times.push_back(static_cast<float>(f / animation.fps));
  tinygltf::AnimationSampler sampler;
  sampler.input = buffer.scalars(times);
  sampler.output = buffer.scalars(animation.weights);
  sampler.interpolation = "LINEAR";
  tinygltf::AnimationChannel channel;
  channel.sampler = 0;
  channel.target_node = 0;
  channel.target_path = "weights";
  tinygltf::Animation clip;
  clip.name = scene.name;
  clip.samplers.push_back(sampler);
  clip.channels.push_back(channel);
  model.animations.push_back(clip);
}

tinygltf::Primitive primitive_of(BufferWriter& buffer, const GlbScene& scene, std::span<const float> normals,
                                 const SplitMesh& split) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  primitive.attributes["POSITION"] = buffer.vectors(split.with_copies(scene.base));
  primitive.attributes["NORMAL"] = buffer.vectors(split.with_copies(normals));
  if (!split.uvs.empty()) {
    std::vector<float> uvs = split.uvs;
    for (std::size_t i = 1; i < uvs.size(); i += 2) uvs[i] = 1 - uvs[i];  // in glTF v grows downwards
    primitive.attributes["TEXCOORD_0"] = buffer.vectors(uvs, 2);
  }
  primitive.indices = buffer.indices(split.triangles);
  return primitive;
}

tinygltf::Material clay_material() {
  tinygltf::Material material;
  material.name = "clay";
  material.pbrMetallicRoughness.baseColorFactor = {0.5, 0.345, 0.275, 1};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.7;
  material.doubleSided = true;
  return material;
}

// One node with the mesh, scaled and turned to glTF's metres and y up.
void add_node(tinygltf::Model& model, const GlbScene& scene) {
  tinygltf::Node node;
  node.name = scene.name;
  node.mesh = 0;
  node.scale.assign(3, metres(scene.units));
  if (scene.up_axis == "z") node.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  model.nodes.push_back(node);
  model.scenes.emplace_back();
  model.scenes[0].nodes.push_back(0);
  model.defaultScene = 0;
}

}  // namespace

void write_glb(const std::filesystem::path& path, const GlbScene& scene) {
  const std::vector<std::uint32_t> triangles = scene.mesh.triangles();
  const std::vector<float> normals = unit_normals(triangles, scene.base);
  const SplitMesh split = split_at_seams(scene.mesh);
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "FaceBaker " FB_VERSION;
  BufferWriter buffer(model);
  const tinygltf::Primitive primitive = primitive_of(buffer, scene, normals, split);
  model.meshes.emplace_back();
  model.meshes[0].name = scene.name;
  model.meshes[0].primitives.push_back(primitive);
  model.materials.push_back(clay_material());
  if (!scene.animation.targets.empty()) add_animation(model, buffer, scene, triangles, normals, split);
  add_node(model, scene);

  // A .glb counts its bytes in 32 bits.
  if (model.buffers[0].data.size() > 0xf0000000u)
    fail(Status::limit, "%s: %zu bytes of animation are more than a .glb holds; write fewer frames",
         shown(path).c_str(), model.buffers[0].data.size());
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true))
    fail(Status::internal, "%s: tinygltf refused to write it", shown(path).c_str());
  write_file(path, stream.str());
}

}  // namespace fb::tool
