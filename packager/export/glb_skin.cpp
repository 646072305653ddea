#include "export/glb_skin.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/status.h"
#include "export/node_transform.h"
#include "export/valid_utf8.h"

namespace fb::tool {
namespace {

using JointFrame = std::array<float, FB_FRAME_FLOATS>;

// What glTF's validator asks of weights that are floats: how far their sum may be from 1, for each that is not 0.
constexpr double sum_tolerance = 2e-7;

// Translation, rotation and scale, so that the joint can be animated; a matrix where they cannot say it.
void set_transform(tinygltf::Node& node, const JointFrame& rows) {
  const NodeTransform transform(rows);
  const Frame said = transform.frame();
  double apart = 0, size = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i % 4 == 3) continue;  // the origin
    apart = std::max(apart, std::fabs(said[i] - double(rows[i])));
    size = std::max(size, std::fabs(double(rows[i])));
  }
  if (apart <= 1e-6 * size) {
    node.translation.assign(transform.translation.begin(), transform.translation.end());
    node.rotation.assign(transform.rotation.begin(), transform.rotation.end());
    node.scale.assign(transform.scale.begin(), transform.scale.end());
    return;
  }
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      node.matrix.push_back(row < 3 ? double(rows[4 * row + column]) : column == 3 ? 1.0 : 0.0);
}

// In the space above the upper node, which scales and, where it turns, turns z up to y up.
JointFrame above(const tinygltf::Node& upper, const float* rest) {
  JointFrame rows;
  const auto scale = static_cast<float>(upper.scale[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    const bool turned = !upper.rotation.empty();
    rows[i] = scale * rest[i];
    rows[4 + i] = scale * rest[(turned ? 8 : 4) + i];
    rows[8 + i] = scale * (turned ? -rest[4 + i] : rest[8 + i]);
  }
  return rows;
}

int inverse_bind_matrices(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character) {
  std::vector<float> matrices;
  for (const fb_joint& joint : character.joints)
    for (std::size_t column = 0; column < 4; ++column)
      for (std::size_t row = 0; row < 4; ++row)
        matrices.push_back(row < 3 ? joint.inverse_bind[4 * row + column] : column == 3 ? 1.0f : 0.0f);
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.type = TINYGLTF_TYPE_MAT4;
  accessor.count = character.joints.size();
  accessor.bufferView = buffer.view(std::as_bytes(std::span(matrices)));
  model.accessors.push_back(accessor);
  return static_cast<int>(model.accessors.size()) - 1;
}

int add_four_joints(tinygltf::Model& model, GlbBuffer& buffer, const std::vector<std::uint16_t>& joints, bool wide) {
  std::vector<std::uint8_t> narrow(joints.begin(), joints.end());
  tinygltf::Accessor accessor;
  accessor.componentType = wide ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  accessor.type = TINYGLTF_TYPE_VEC4;
  accessor.count = joints.size() / 4;
  accessor.bufferView = buffer.view(wide ? std::as_bytes(std::span(joints)) : std::as_bytes(std::span(narrow)),
                                    TINYGLTF_TARGET_ARRAY_BUFFER);
  model.accessors.push_back(accessor);
  return static_cast<int>(model.accessors.size()) - 1;
}

}  // namespace

bool is_skinned(const CharacterView& character, std::size_t mesh) {
  const fb_mesh& of = character.meshes[mesh];
  return character.influences > 0 && character.skin_weights[std::size_t(character.influences) * of.first_vertex] > 0;
}

std::vector<int> add_joints(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character) {
  const auto is_root = [](const fb_joint& joint) { return joint.parent == FB_NO_JOINT; };
  const bool one_root = std::ranges::count_if(character.joints, is_root) == 1;
  const int first = static_cast<int>(model.nodes.size());
  tinygltf::Skin skin;
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const fb_joint& joint = character.joints[j];
    const int index = first + static_cast<int>(j);
    JointFrame rows;
    std::copy_n(joint.rest, rows.size(), rows.begin());
    if (is_root(joint) && one_root) {
      rows = above(model.nodes[0], joint.rest);
      model.scenes[0].nodes.push_back(index);
    } else {
      model.nodes[is_root(joint) ? 0 : static_cast<std::size_t>(first) + joint.parent].children.push_back(index);
    }
    tinygltf::Node node;
    node.name = valid_utf8(joint.name);
    set_transform(node, rows);
    model.nodes.push_back(node);
    skin.joints.push_back(index);
  }
  if (character.influences == 0) return skin.joints;
  skin.inverseBindMatrices = inverse_bind_matrices(model, buffer, character);
  model.skins.push_back(skin);
  return skin.joints;
}

void add_influences(tinygltf::Model& model, std::map<std::string, int>& attributes, GlbBuffer& buffer,
                    const CharacterView& character, std::size_t mesh, const SplitMesh& split) {
  const std::size_t influences = character.influences, first = character.meshes[mesh].first_vertex;
  std::vector<std::size_t> vertices;
  for (std::size_t v = 0; v < character.meshes[mesh].vertex_count; ++v) vertices.push_back(first + v);
  for (const std::uint32_t copied : split.copied) vertices.push_back(first + copied);
  std::size_t most = 0;
  for (const std::size_t v : vertices)
    for (std::size_t k = 0; k < influences; ++k)
      if (character.skin_weights[v * influences + k] > 0) most = std::max(most, k + 1);
  for (std::size_t set = 0; 4 * set < most; ++set) {
    std::vector<std::uint16_t> joints;
    std::vector<float> weights;
    for (const std::size_t v : vertices) {
      const auto of_vertex = character.skin_weights.subspan(v * influences, influences);
      double sum = 0;
      for (const float weight : of_vertex) sum += double(weight);
      const bool is_one = std::fabs(sum - 1) <= sum_tolerance;
      for (std::size_t k = 4 * set; k < 4 * set + 4; ++k) {
        const bool used = k < influences && of_vertex[k] > 0;
        joints.push_back(used ? character.skin_joints[v * influences + k] : std::uint16_t{0});
        weights.push_back(!used ? 0.0f : is_one ? of_vertex[k] : static_cast<float>(double(of_vertex[k]) / sum));
      }
    }
    attributes[format("JOINTS_%zu", set)] = add_four_joints(model, buffer, joints, character.joints.size() > 256);
    attributes[format("WEIGHTS_%zu", set)] = buffer.vectors(weights, 4);
  }
}

}  // namespace fb::tool
