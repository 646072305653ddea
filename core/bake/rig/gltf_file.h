#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/mesh.h"

namespace tinygltf {
class Model;
struct Accessor;
struct Mesh;
struct Primitive;
}  // namespace tinygltf

namespace fb::bake {

// A glTF 2.0 file in memory, binary or text. The loader does not check what the file declares; everything read through
// this class is checked against the size of its buffers. Messages do not name the file: see with_context.
class GltfFile {
 public:
  // Fails on what is truncated or no glTF, on data in other files (textures excepted, which are not read), and on
  // required extensions that store geometry in another way, such as Draco's.
  explicit GltfFile(std::span<const std::byte> bytes);
  ~GltfFile();

  const tinygltf::Model& model() const { return *model_; }
  // An accessor of `width` floats an element (1 to 3; of 2, also normalised integers). With `count`, it must have that
  // many elements, and those without a buffer are zeros; without `count`, all must be stored. `what` names it in
  // messages: "positions".
  std::vector<float> floats(int accessor, std::size_t width, std::optional<std::size_t> count, const char* what) const;
  // The primitives of a mesh one after the other; indexed triangles only. No transform is applied. Texture coordinates
  // are the first, if every primitive has them.
  Mesh triangles(const tinygltf::Mesh& mesh) const;

 private:
  const tinygltf::Accessor& accessor(int index, const char* what) const;
  std::span<const unsigned char> bytes(int view, std::size_t offset, std::size_t count, std::size_t element_bytes,
                                       std::size_t& stride, const char* what) const;
  void overwrite_sparse(const tinygltf::Accessor& accessor, std::size_t width, std::span<float> values,
                        const char* what) const;
  std::vector<std::uint32_t> indices(int view, std::size_t offset, std::size_t count, int component_type,
                                     std::size_t limit, const char* what) const;

  std::unique_ptr<tinygltf::Model> model_;
};

}  // namespace fb::bake
