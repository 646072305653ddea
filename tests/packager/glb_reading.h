// An independent reader of .glb files that checks the rules of the glTF specification.
#pragma once

#include <doctest/doctest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

inline tinygltf::Model load_glb(const std::string& path) {
  tinygltf::Model model;
  tinygltf::TinyGLTF loader;
  // Images stay the files they are.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  std::string error, warning;
  const bool loaded = loader.LoadBinaryFromFile(&model, &error, &warning, path);
  CAPTURE(error);
  CAPTURE(warning);
  REQUIRE(loaded);
  CHECK(error.empty());
  CHECK(warning.empty());
  return model;
}

template <class T>
std::vector<T> view_values(const tinygltf::Model& model, int view, std::size_t offset, std::size_t count) {
  const auto& v = model.bufferViews.at(view);
  const auto& data = model.buffers.at(v.buffer).data;
  REQUIRE(v.byteOffset + offset + count * sizeof(T) <= data.size());
  REQUIRE(offset + count * sizeof(T) <= v.byteLength);
  std::vector<T> values(count);
  std::memcpy(values.data(), data.data() + v.byteOffset + offset, count * sizeof(T));
  return values;
}

// Floats of an accessor, sparse or not, that lie within the bounds it states.
inline std::vector<float> floats(const tinygltf::Model& model, int index) {
  const auto& a = model.accessors.at(index);
  REQUIRE(a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT);
  const std::size_t width = a.type == TINYGLTF_TYPE_SCALAR ? 1 : std::size_t(a.type);  // VEC2 is 2, and so on
  std::vector<float> values(a.count * width);
  if (a.bufferView >= 0) values = view_values<float>(model, a.bufferView, a.byteOffset, values.size());
  if (a.sparse.isSparse) {
    const auto where = view_values<std::uint32_t>(model, a.sparse.indices.bufferView, 0, a.sparse.count);
    const auto what = view_values<float>(model, a.sparse.values.bufferView, 0, a.sparse.count * width);
    CHECK(std::is_sorted(where.begin(), where.end()));
    for (std::size_t i = 0; i < where.size(); ++i) {
      REQUIRE(where[i] < a.count);
      std::copy_n(&what[i * width], width, &values[where[i] * width]);
    }
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    CHECK(values[i] >= a.minValues.at(i % width));
    CHECK(values[i] <= a.maxValues.at(i % width));
  }
  return values;
}

// The node of this name.
inline const tinygltf::Node& node_named(const tinygltf::Model& model, std::string_view name) {
  const auto found =
      std::find_if(model.nodes.begin(), model.nodes.end(), [&](const auto& n) { return n.name == name; });
  REQUIRE_MESSAGE(found != model.nodes.end(), std::string(name));
  return *found;
}

// The values of the animation's channel of a node, all frames; empty if it has none.
inline std::vector<float> channel_of(const tinygltf::Model& model, const std::string& node, const std::string& path) {
  REQUIRE(model.animations.size() == 1);
  const auto& animation = model.animations[0];
  for (const auto& channel : animation.channels)
    if (model.nodes.at(channel.target_node).name == node && channel.target_path == path)
      return floats(model, animation.samplers.at(channel.sampler).output);
  return {};
}

// Points of the mesh of a node with these weights of its targets, as the glTF specification says.
inline std::vector<float> morphed_points(const tinygltf::Model& model, const tinygltf::Node& node,
                                         const float* weights) {
  const auto& primitive = model.meshes.at(node.mesh).primitives.at(0);
  std::vector<float> points = floats(model, primitive.attributes.at("POSITION"));
  for (std::size_t t = 0; t < primitive.targets.size(); ++t) {
    const auto moves = floats(model, primitive.targets[t].at("POSITION"));
    REQUIRE(moves.size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += weights[t] * moves[i];
  }
  return points;
}

inline float largest_difference(const float* a, const float* b, std::size_t count) {
  float largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}
