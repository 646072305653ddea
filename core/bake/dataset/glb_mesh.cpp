#include <tiny_gltf.h>

#include <cstring>

#include "bake/dataset/rest_mesh.h"
#include "base/checked.h"
#include "base/file.h"
#include "base/status.h"

namespace fb {
namespace {

// The bytes of element `index` of an accessor are at data + index * stride.
struct Elements {
  const unsigned char* data;
  std::size_t stride, count;
};

class GlbReader {
 public:
  GlbReader(const tinygltf::Model& model, const char* file) : model_(model), file_(file) {}

  Mesh read() const {
    if (model_.meshes.size() != 1)
      fail(Status::bad_data, "%s: holds %zu meshes; a rest mesh is the only one in its file", file_,
           model_.meshes.size());
    Mesh mesh;
    for (const tinygltf::Primitive& primitive : model_.meshes[0].primitives) append(primitive, mesh);
    return mesh;
  }

 private:
  // Bounds are ours to check: the loader hands out what the file claims.
  Elements elements(int accessor_index, const char* what, std::size_t element_bytes) const {
    if (accessor_index < 0 || static_cast<std::size_t>(accessor_index) >= model_.accessors.size())
      fail(Status::bad_data, "%s: no accessor %d for its %s", file_, accessor_index, what);
    const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(accessor_index)];
    if (accessor.sparse.isSparse) fail(Status::unsupported, "%s: its %s are sparse", file_, what);
    if (accessor.bufferView < 0 || static_cast<std::size_t>(accessor.bufferView) >= model_.bufferViews.size())
      fail(Status::bad_data, "%s: its %s lie in no buffer view", file_, what);
    const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_.buffers.size())
      fail(Status::bad_data, "%s: its %s lie in no buffer", file_, what);
    const std::vector<unsigned char>& bytes = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
    const std::size_t stride = view.byteStride ? view.byteStride : element_bytes;
    const std::size_t first = checked_add(view.byteOffset, accessor.byteOffset, file_);
    if (accessor.count == 0) fail(Status::bad_data, "%s: has no %s", file_, what);
    const std::size_t span = checked_add(checked_multiply(accessor.count - 1, stride, file_), element_bytes, file_);
    if (checked_add(first, span, file_) > bytes.size())
      fail(Status::bad_data, "%s: its %s run past the end of their buffer", file_, what);
    return {bytes.data() + first, stride, accessor.count};
  }

  const tinygltf::Accessor& accessor(int index) const { return model_.accessors.at(static_cast<std::size_t>(index)); }

  void append(const tinygltf::Primitive& primitive, Mesh& mesh) const {
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
      fail(Status::unsupported, "%s: a primitive is not made of triangles", file_);
    const auto found = primitive.attributes.find("POSITION");
    if (found == primitive.attributes.end()) fail(Status::bad_data, "%s: a primitive has no positions", file_);
    const Elements positions = elements(found->second, "positions", 3 * sizeof(float));
    if (accessor(found->second).componentType != TINYGLTF_COMPONENT_TYPE_FLOAT ||
        accessor(found->second).type != TINYGLTF_TYPE_VEC3)
      fail(Status::bad_data, "%s: positions are not three floats", file_);
    const std::size_t base = mesh.vertex_count();
    mesh.points.resize(3 * (base + positions.count));
    for (std::size_t i = 0; i < positions.count; ++i)
      std::memcpy(&mesh.points[3 * (base + i)], positions.data + i * positions.stride, 3 * sizeof(float));
    if (primitive.indices < 0) fail(Status::unsupported, "%s: a primitive has no indices", file_);
    append_triangles(primitive.indices, base, mesh);
  }

  void append_triangles(int index, std::size_t base, Mesh& mesh) const {
    elements(index, "indices", 1);
    const int type = accessor(index).componentType;
    const std::size_t width = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 1
                              : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                              : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? 4
                                                                               : 0;
    if (width == 0) fail(Status::bad_data, "%s: indices are not unsigned integers", file_);
    const Elements indices = elements(index, "indices", width);
    if (indices.count % 3 != 0) fail(Status::bad_data, "%s: %zu indices make no triangles", file_, indices.count);
    for (std::size_t i = 0; i < indices.count; ++i) {
      std::uint32_t corner = 0;
      std::memcpy(&corner, indices.data + i * indices.stride, width);
      mesh.polygon_corners.push_back(checked_u32(base + corner, file_));
    }
    mesh.polygon_sizes.insert(mesh.polygon_sizes.end(), indices.count / 3, 3);
  }

  const tinygltf::Model& model_;
  const char* file_;
};

}  // namespace

Mesh read_glb(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  tinygltf::TinyGLTF loader;
  // Textures are of no interest.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error, warning;
  if (!loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()),
                                   static_cast<unsigned>(bytes.size())))
    fail(Status::bad_data, "%s: %s", path.c_str(), error.empty() ? "is no glTF binary" : error.c_str());
  return GlbReader(model, path.c_str()).read();
}

}  // namespace fb
