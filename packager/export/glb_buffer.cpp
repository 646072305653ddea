#include "export/glb_buffer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace fb::tool {
namespace {

tinygltf::Accessor accessor_of(std::span<const float> values, int width) {
  static constexpr int types[] = {TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.type = types[width - 1];
  accessor.count = values.size() / static_cast<std::size_t>(width);
  accessor.minValues.assign(static_cast<std::size_t>(width), INFINITY);
  accessor.maxValues.assign(static_cast<std::size_t>(width), -INFINITY);
  for (std::size_t i = 0; i < values.size(); ++i) {
    double &low = accessor.minValues[i % static_cast<std::size_t>(width)],
           &high = accessor.maxValues[i % static_cast<std::size_t>(width)];
    low = std::min(low, double(values[i]));
    high = std::max(high, double(values[i]));
  }
  return accessor;
}

}  // namespace

bool is_sparse(std::size_t moved, std::size_t vertices) {
  return moved > 0 && moved <= vertices / 2;
}

int GlbBuffer::view(std::span<const std::byte> bytes, int target) {
  auto& data = model_.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = bytes.size();
  view.target = target;
  data.resize((data.size() + bytes.size() + 3) / 4 * 4);
  if (!bytes.empty()) std::memcpy(data.data() + view.byteOffset, bytes.data(), bytes.size());
  model_.bufferViews.push_back(view);
  return static_cast<int>(model_.bufferViews.size()) - 1;
}

int GlbBuffer::vectors(std::span<const float> values, int width, int target) {
  tinygltf::Accessor accessor = accessor_of(values, width);
  accessor.bufferView = view(std::as_bytes(values), target);
  return add(accessor);
}

int GlbBuffer::displacements(std::span<const float> values) {
  std::vector<std::uint32_t> indices;
  std::vector<float> nonzero;
  for (std::size_t v = 0; v < values.size() / 3; ++v) {
    const auto vector = values.subspan(3 * v, 3);
    if (vector[0] == 0 && vector[1] == 0 && vector[2] == 0) continue;
    indices.push_back(static_cast<std::uint32_t>(v));
    nonzero.insert(nonzero.end(), vector.begin(), vector.end());
  }
  if (indices.empty()) return add(accessor_of(values, 3));
  if (!is_sparse(indices.size(), values.size() / 3)) return vectors(values, 3);
  tinygltf::Accessor accessor = accessor_of(values, 3);
  accessor.sparse.isSparse = true;
  accessor.sparse.count = static_cast<int>(indices.size());
  accessor.sparse.indices.bufferView = view(std::as_bytes(std::span(indices)));
  accessor.sparse.indices.byteOffset = 0;
  accessor.sparse.indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  accessor.sparse.values.bufferView = view(std::as_bytes(std::span(nonzero)));
  accessor.sparse.values.byteOffset = 0;
  return add(accessor);
}

int GlbBuffer::indices(std::span<const std::uint32_t> values) {
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  accessor.type = TINYGLTF_TYPE_SCALAR;
  accessor.count = values.size();
  accessor.bufferView = view(std::as_bytes(values), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  return add(accessor);
}

int GlbBuffer::add(const tinygltf::Accessor& accessor) {
  model_.accessors.push_back(accessor);
  return static_cast<int>(model_.accessors.size()) - 1;
}

}  // namespace fb::tool
