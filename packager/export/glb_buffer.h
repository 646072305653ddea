// The one buffer of a .glb.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <span>

namespace fb::tool {

// True if a target that moves so many vertices is stored as a sparse accessor: at least one, and at most half of all.
bool is_sparse(std::size_t moved, std::size_t vertices);

// Appends arrays to the buffer of a model, with their views and accessors. Each function gives the index of what it
// has added.
class GlbBuffer {
 public:
  explicit GlbBuffer(tinygltf::Model& model) : model_(model) { model_.buffers.emplace_back(); }

  // A view of bytes, at a multiple of four. target: what vertex data are for, or 0.
  int view(std::span<const std::byte> bytes, int target = 0);
  // `width` floats each: 1 to 4.
  int vectors(std::span<const float> values, int width, int target = TINYGLTF_TARGET_ARRAY_BUFFER);
  // Three floats each; see is_sparse. Where all are 0, nothing is stored.
  int displacements(std::span<const float> values);
  int indices(std::span<const std::uint32_t> values);

 private:
  int add(const tinygltf::Accessor& accessor);

  tinygltf::Model& model_;
};

}  // namespace fb::tool
