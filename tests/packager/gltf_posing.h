// What a glTF file shows in a pose, by the rules of glTF 2.0 alone: nodes, morph targets and skins.
#pragma once

#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "glb_reading.h"
#include "skinning.h"

namespace fb::test {

struct GltfPose {
  std::map<std::string, Place> locals;    // of nodes that are not as in the file, by name
  std::map<std::string, double> weights;  // of morph targets, by name; others are 0
};

inline Place local_place(const tinygltf::Node& node) {
  Place m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (node.matrix.size() == 16) std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
  if (node.rotation.size() == 4) {
    const double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    m = {1 - 2 * (y * y + z * z),
         2 * (x * y + z * w),
         2 * (x * z - y * w),
         0,
         2 * (x * y - z * w),
         1 - 2 * (x * x + z * z),
         2 * (y * z + x * w),
         0,
         2 * (x * z + y * w),
         2 * (y * z - x * w),
         1 - 2 * (x * x + y * y),
         0,
         0,
         0,
         0,
         1};
  }
  for (std::size_t i = 0; i < node.scale.size(); ++i)
    for (std::size_t row = 0; row < 3; ++row) m[4 * i + row] *= node.scale[i];
  std::copy(node.translation.begin(), node.translation.end(), m.begin() + 12);
  return m;
}

// Of each node, to the scene.
inline std::vector<Place> node_places(const tinygltf::Model& model, const GltfPose& pose) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (std::size_t n = 0; n < model.nodes.size(); ++n)
    for (const int child : model.nodes[n].children) parents.at(std::size_t(child)) = int(n);
  std::vector<Place> places;
  for (std::size_t n = 0; n < model.nodes.size(); ++n) {
    const auto local = [&](int node) {
      const auto found = pose.locals.find(model.nodes[std::size_t(node)].name);
      return found == pose.locals.end() ? local_place(model.nodes[std::size_t(node)]) : found->second;
    };
    Place place = local(int(n));
    for (int above = parents[n]; above >= 0; above = parents[std::size_t(above)]) place = times(local(above), place);
    places.push_back(place);
  }
  return places;
}

// Four joints of each vertex.
inline std::vector<std::size_t> joint_numbers(const tinygltf::Model& model, int index) {
  const auto& a = model.accessors.at(index);
  REQUIRE(a.type == TINYGLTF_TYPE_VEC4);
  std::vector<std::size_t> joints;
  if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) {
    const auto bytes = view_values<std::uint8_t>(model, a.bufferView, a.byteOffset, 4 * a.count);
    joints.assign(bytes.begin(), bytes.end());
  } else {
    REQUIRE(a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
    const auto numbers = view_values<std::uint16_t>(model, a.bufferView, a.byteOffset, 4 * a.count);
    joints.assign(numbers.begin(), numbers.end());
  }
  return joints;
}

// A blend of four joints a vertex, added to those of other sets.
inline void add_blends(const tinygltf::Model& model, const std::map<std::string, int>& attributes, int set,
                       const std::vector<Place>& matrices, std::vector<Place>& blends) {
  const std::string number = std::to_string(set);
  const std::vector<std::size_t> joints = joint_numbers(model, attributes.at("JOINTS_" + number));
  const std::vector<float> weights = floats(model, attributes.at("WEIGHTS_" + number));
  REQUIRE(joints.size() == weights.size());
  blends.resize(joints.size() / 4);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    for (std::size_t k = 0; k < 16; ++k) blends[i / 4][k] += double(weights[i]) * matrices.at(joints[i])[k];
  }
}

// From the mesh to the scene, for each joint of a skin.
inline std::vector<Place> joint_matrices(const tinygltf::Model& model, const tinygltf::Skin& skin,
                                         const std::vector<Place>& places) {
  const auto& accessor = model.accessors.at(skin.inverseBindMatrices);
  REQUIRE(accessor.type == TINYGLTF_TYPE_MAT4);
  REQUIRE(accessor.count == skin.joints.size());
  const auto inverses = view_values<float>(model, accessor.bufferView, accessor.byteOffset, 16 * accessor.count);
  std::vector<Place> matrices;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    Place inverse;
    std::copy_n(&inverses[16 * j], 16, inverse.begin());
    CHECK((inverse[3] == 0 && inverse[7] == 0 && inverse[11] == 0 && inverse[15] == 1));
    matrices.push_back(times(places.at(skin.joints[j]), inverse));
  }
  return matrices;
}

// Points of a primitive of a node in the scene.
inline std::vector<double> posed_points(const tinygltf::Model& model, const tinygltf::Node& node,
                                        const tinygltf::Primitive& primitive, const std::vector<Place>& places,
                                        const Place& place, const GltfPose& pose) {
  const auto& mesh = model.meshes.at(node.mesh);
  const std::vector<float> rest = floats(model, primitive.attributes.at("POSITION"));
  std::vector<double> points(rest.begin(), rest.end());
  for (std::size_t t = 0; t < primitive.targets.size(); ++t) {
    const auto name = mesh.extras.Get("targetNames").Get(int(t)).Get<std::string>();
    const auto weight = pose.weights.find(name);
    const std::vector<float> moves = floats(model, primitive.targets[t].at("POSITION"));
    for (std::size_t i = 0; weight != pose.weights.end() && i < points.size(); ++i)
      points[i] += weight->second * double(moves[i]);
  }
  std::vector<Place> blends(points.size() / 3, place);
  if (node.skin >= 0) {
    const std::vector<Place> matrices = joint_matrices(model, model.skins.at(node.skin), places);
    blends.clear();
    for (int set = 0; primitive.attributes.contains("JOINTS_" + std::to_string(set)); ++set)
      add_blends(model, primitive.attributes, set, matrices, blends);
  }
  REQUIRE(3 * blends.size() == points.size());
  for (std::size_t v = 0; v < blends.size(); ++v) {
    const Place& m = blends[v];
    CHECK(m[15] == doctest::Approx(1).epsilon(1e-6));
    const double x = points[3 * v], y = points[3 * v + 1], z = points[3 * v + 2];
    for (std::size_t a = 0; a < 3; ++a) points[3 * v + a] = m[a] * x + m[4 + a] * y + m[8 + a] * z + m[12 + a];
  }
  return points;
}

// Of the mesh of a node: of its primitives, those that share vertices once.
inline std::vector<double> posed_points(const tinygltf::Model& model, const tinygltf::Node& node,
                                        const std::vector<Place>& places, const Place& place, const GltfPose& pose) {
  std::vector<double> all;
  std::set<int> seen;
  for (const auto& primitive : model.meshes.at(node.mesh).primitives) {
    if (!seen.insert(primitive.attributes.at("POSITION")).second) continue;
    const std::vector<double> points = posed_points(model, node, primitive, places, place, pose);
    all.insert(all.end(), points.begin(), points.end());
  }
  return all;
}

// What an animation makes of nodes and weights in a frame.
inline GltfPose pose_of_animation(const tinygltf::Model& model, const tinygltf::Animation& animation,
                                  std::size_t frame) {
  std::map<std::string, tinygltf::Node> moved;
  GltfPose pose;
  for (const auto& channel : animation.channels) {
    const tinygltf::Node& node = model.nodes.at(std::size_t(channel.target_node));
    const std::vector<float> values = floats(model, animation.samplers.at(std::size_t(channel.sampler)).output);
    const std::size_t count = floats(model, animation.samplers.at(std::size_t(channel.sampler)).input).size(),
                      width = values.size() / count;
    const std::vector<double> value(values.begin() + std::ptrdiff_t(frame * width),
                                    values.begin() + std::ptrdiff_t((frame + 1) * width));
    if (channel.target_path == "weights") {
      const auto& mesh = model.meshes.at(std::size_t(node.mesh));
      for (std::size_t t = 0; t < width; ++t)
        pose.weights[mesh.extras.Get("targetNames").Get(int(t)).Get<std::string>()] = value[t];
      continue;
    }
    tinygltf::Node& to = moved.try_emplace(node.name, node).first->second;
    if (channel.target_path == "translation") to.translation = value;
    if (channel.target_path == "rotation") to.rotation = value;
    if (channel.target_path == "scale") to.scale = value;
  }
  for (const auto& [name, node] : moved) pose.locals[name] = local_place(node);
  return pose;
}

// The nodes of the default scene.
inline std::set<int> shown_nodes(const tinygltf::Model& model) {
  std::vector<int> next = model.scenes.at(model.defaultScene).nodes;
  std::set<int> shown;
  while (!next.empty()) {
    const int node = next.back();
    next.pop_back();
    shown.insert(node);
    next.insert(next.end(), model.nodes.at(node).children.begin(), model.nodes.at(node).children.end());
  }
  return shown;
}

// Points of all meshes, in the order of nodes; 3 x `vertices` of each: those that a writer adds behind are left out.
inline std::vector<double> posed_points(const tinygltf::Model& model, const GltfPose& pose,
                                        const std::vector<std::size_t>& vertices = {}) {
  const std::vector<Place> places = node_places(model, pose);
  std::vector<double> all;
  std::size_t meshes = 0;
  const std::set<int> shown = shown_nodes(model);
  for (std::size_t n = 0; n < model.nodes.size(); ++n) {
    if (model.nodes[n].mesh < 0 || !shown.contains(int(n))) continue;
    const std::vector<double> points = posed_points(model, model.nodes[n], places, places[n], pose);
    const std::size_t count = vertices.empty() ? points.size() : 3 * vertices.at(meshes);
    REQUIRE(points.size() >= count);
    all.insert(all.end(), points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count));
    ++meshes;
  }
  return all;
}

// The largest distance of a point from that of the same number.
inline double largest_distance(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); i += 3)
    largest = std::max(largest, std::hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]));
  return largest;
}

}  // namespace fb::test
