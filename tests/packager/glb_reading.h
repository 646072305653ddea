// An independent reader of .glb files that checks the rules of the glTF specification.
#pragma once

#include <doctest/doctest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

inline tinygltf::Model load_glb(const std::string& path) {
  tinygltf::Model model;
  tinygltf::TinyGLTF loader;
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
  const std::size_t width = a.type == TINYGLTF_TYPE_VEC3 ? 3 : a.type == TINYGLTF_TYPE_VEC2 ? 2 : 1;
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
