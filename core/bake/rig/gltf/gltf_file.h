#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
struct Accessor;
}  // namespace tinygltf

namespace fb::bake {

class FilesBeside;

// A glTF 2.0 file in memory, binary or text. The loader does not check what the file declares; everything read through
// this class is checked against the size of its buffers. Messages do not name the file: see with_context.
class GltfFile {
 public:
  // `folder`: where the file lies; its buffers and images may lie there too, and nowhere else. Without it no other file
  // is read. What meshopt and Draco compress is decoded. Fails on what is truncated or no glTF, on buffers that are
  // missing, and on required extensions that are not read.
  explicit GltfFile(std::span<const std::byte> bytes, std::optional<std::filesystem::path> folder = std::nullopt);
  ~GltfFile();

  const tinygltf::Model& model() const { return *model_; }
  // An accessor of `width` numbers an element (1 to 4, or 16 of a matrix, column after column). Integers of 8 and 16
  // bits are converted, those that are normalised to 0..1 or -1..1. With `count`, it must have that many elements, and
  // those without a buffer are zeros; without `count`, they must be stored or sparse. `what` names it in messages:
  // "positions".
  std::vector<float> floats(int accessor, std::size_t width, std::optional<std::size_t> count, const char* what) const;
  // An accessor of `width` (1 or 4) unsigned integers an element, all below `limit`; with `count`, that many elements.
  // Of sparse ones without a buffer the others are 0.
  std::vector<std::uint32_t> indices(int accessor, std::size_t width, std::optional<std::size_t> count,
                                     std::size_t limit, const char* what) const;
  // Elements of an accessor.
  std::size_t count(int accessor, const char* what) const;
  // The bytes of a buffer view.
  std::span<const std::byte> view(int index, const char* what) const;
  // What a URI means, as written in the file: the data within it, or a file beside.
  std::vector<std::byte> read_uri(const std::string& uri) const;

 private:
  struct Scalars;
  const tinygltf::Accessor& accessor(int index, std::size_t width, const char* what) const;
  std::span<const unsigned char> bytes(int view, std::size_t offset, std::size_t count, std::size_t element_bytes,
                                       std::size_t& stride, const char* what) const;
  std::vector<std::uint32_t> sparse_elements(const tinygltf::Accessor& accessor, const char* what) const;
  void overwrite_sparse(const tinygltf::Accessor& accessor, std::size_t width, std::span<float> values,
                        const char* what) const;
  std::vector<std::uint32_t> indices(const Scalars& from, std::size_t limit, const char* what) const;

  std::unique_ptr<tinygltf::Model> model_;
  std::unique_ptr<FilesBeside> beside_;
};

}  // namespace fb::bake
