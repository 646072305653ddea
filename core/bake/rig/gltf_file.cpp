#include "bake/rig/gltf_file.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "base/checked.h"
#include "base/json_depth.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Keeps the loader from opening any other file.
constexpr tinygltf::FsCallbacks this_file_only = {
    [](const std::string&, void*) { return true; }, [](const std::string& path, void*) { return path; },
    [](std::vector<unsigned char>*, std::string* error, const std::string&, void*) {
      *error = "other files are not read; export everything into one .glb";
      return false;
    },
    nullptr, nullptr};

// Refuses required extensions except those of materials and textures, which do not change geometry.
void check_extensions(const tinygltf::Model& model) {
  for (const std::string& name : model.extensionsRequired)
    if (!name.starts_with("KHR_materials_") && !name.starts_with("KHR_texture_") && !name.starts_with("EXT_texture_"))
      fail(Status::unsupported, "requires the glTF extension %s, which is not read; export without it", name.c_str());
}

// The JSON of a file: all of it, or the first chunk of a binary one, after a header of 20 bytes that ends in the
// chunk's length and type.
std::string_view json_of(std::span<const std::byte> bytes, bool binary) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!binary) return text;
  std::uint32_t length = 0;
  if (bytes.size() >= 20) std::memcpy(&length, bytes.data() + 12, sizeof length);
  return text.substr(std::min<std::size_t>(20, text.size()), length);
}

}  // namespace

GltfFile::GltfFile(std::span<const std::byte> bytes) : model_(std::make_unique<tinygltf::Model>()) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(this_file_only);
  // Textures are not decoded.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  std::string error, warning;
  const auto size = checked_u32(bytes.size(), "bytes");
  const bool binary = size >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  check_json_depth(json_of(bytes, binary));
  const char* text = reinterpret_cast<const char*>(bytes.data());
  bool loaded = false;
  try {
    loaded = binary ? loader.LoadBinaryFromMemory(model_.get(), &error, &warning,
                                                  reinterpret_cast<const unsigned char*>(text), size)
                    : loader.LoadASCIIFromString(model_.get(), &error, &warning, text, size, "");
  } catch (const std::out_of_range&) {
    error = "a buffer is empty";  // which the loader does not expect
  }
  check_extensions(*model_);  // first: a required extension may be why it was not loaded
  while (!error.empty() && error.back() == '\n') error.pop_back();
  if (!loaded) fail(Status::bad_data, "is no whole glTF file%s%s", error.empty() ? "" : ": ", error.c_str());
}

GltfFile::~GltfFile() = default;

const tinygltf::Accessor& GltfFile::accessor(int index, const char* what) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_->accessors.size())
    fail(Status::bad_data, "no accessor %d for its %s", index, what);
  return model_->accessors[static_cast<std::size_t>(index)];
}

// From the first byte of the first element to the last byte of the last; elements are `stride` apart.
std::span<const unsigned char> GltfFile::bytes(int view_index, std::size_t offset, std::size_t count,
                                               std::size_t element_bytes, std::size_t& stride, const char* what) const {
  if (count == 0) fail(Status::bad_data, "has no %s", what);
  if (view_index < 0 || static_cast<std::size_t>(view_index) >= model_->bufferViews.size())
    fail(Status::bad_data, "its %s lie in no buffer view", what);
  const tinygltf::BufferView& view = model_->bufferViews[static_cast<std::size_t>(view_index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_->buffers.size())
    fail(Status::bad_data, "its %s lie in no buffer", what);
  const std::vector<unsigned char>& data = model_->buffers[static_cast<std::size_t>(view.buffer)].data;
  stride = view.byteStride ? view.byteStride : element_bytes;
  const std::size_t first = checked_add(view.byteOffset, offset, what);
  const std::size_t length = checked_add(checked_multiply(count - 1, stride, what), element_bytes, what);
  if (checked_add(first, length, what) > data.size())
    fail(Status::bad_data, "its %s run past the end of their buffer", what);
  return std::span(data).subspan(first, length);
}

std::vector<float> GltfFile::floats(int index, std::size_t width, std::optional<std::size_t> count,
                                    const char* what) const {
  const tinygltf::Accessor& from = accessor(index, what);
  static constexpr int types[] = {TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3};
  static constexpr const char* each[] = {"floats", "two floats each", "three floats each"};
  // Texture coordinates may be normalised integers.
  const std::size_t component_bytes = from.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT            ? sizeof(float)
                                      : width != 2 || !from.normalized || from.sparse.isSparse       ? 0
                                      : from.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                                      : from.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE  ? 1
                                                                                                     : 0;
  if (component_bytes == 0 || from.type != types[width - 1])
    fail(Status::unsupported, "its %s are not %s", what, each[width - 1]);
  if (count && from.count != *count)
    fail(Status::bad_data, "has %zu %s where %zu are needed", from.count, what, *count);
  const bool stored = from.bufferView >= 0 || !count;
  const std::size_t element_bytes = width * component_bytes;
  std::size_t stride = 0;
  const auto data = stored ? bytes(from.bufferView, from.byteOffset, from.count, element_bytes, stride, what)
                           : std::span<const unsigned char>();
  std::vector<float> values(checked_multiply(from.count, width, what));
  for (std::size_t i = 0; stored && i < from.count; ++i) {
    if (component_bytes == sizeof(float)) {
      std::memcpy(&values[i * width], data.data() + i * stride, element_bytes);
      continue;
    }
    for (std::size_t axis = 0; axis < width; ++axis) {
      std::uint16_t fraction = 0;
      std::memcpy(&fraction, data.data() + i * stride + axis * component_bytes, component_bytes);
      values[i * width + axis] = static_cast<float>(fraction) / (component_bytes == 2 ? 65535.0f : 255.0f);
    }
  }
  if (from.sparse.isSparse) overwrite_sparse(from, width, values, what);
  return values;
}

void GltfFile::overwrite_sparse(const tinygltf::Accessor& from, std::size_t width, std::span<float> values,
                                const char* what) const {
  const auto& sparse = from.sparse;
  if (sparse.count < 1 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
    fail(Status::bad_data, "its sparse %s have a count or an offset below zero", what);
  const auto count = static_cast<std::size_t>(sparse.count);
  const std::vector<std::uint32_t> elements =
      indices(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count,
              sparse.indices.componentType, from.count, what);
  std::size_t stride = 0;
  const auto data = bytes(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), count,
                          width * sizeof(float), stride, what);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&values[elements[i] * width], data.data() + i * stride, width * sizeof(float));
}

std::vector<std::uint32_t> GltfFile::indices(int view, std::size_t offset, std::size_t count, int component_type,
                                             std::size_t limit, const char* what) const {
  const std::size_t width = component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 1
                            : component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                            : component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? 4
                                                                                       : 0;
  if (width == 0) fail(Status::bad_data, "the indices of its %s are not unsigned integers", what);
  std::size_t stride = 0;
  const auto data = bytes(view, offset, count, width, stride, what);
  std::vector<std::uint32_t> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(&values[i], data.data() + i * stride, width);
    if (values[i] >= limit) fail(Status::bad_data, "index %zu of its %s is %u of %zu", i, what, values[i], limit);
  }
  return values;
}

Mesh GltfFile::triangles(const tinygltf::Mesh& from) const {
  Mesh mesh;
  for (const tinygltf::Primitive& primitive : from.primitives) {
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
      fail(Status::unsupported, "a primitive is not made of triangles");
    const auto found = primitive.attributes.find("POSITION");
    if (found == primitive.attributes.end()) fail(Status::bad_data, "a primitive has no positions");
    if (primitive.indices < 0) fail(Status::unsupported, "a primitive has no indices");
    const std::vector<float> points = floats(found->second, 3, std::nullopt, "positions");
    const tinygltf::Accessor& corners = accessor(primitive.indices, "triangles");
    if (corners.count % 3 != 0) fail(Status::bad_data, "%zu indices make no triangles", corners.count);
    if (corners.sparse.isSparse) fail(Status::unsupported, "its triangles are sparse");
    const std::size_t base = mesh.vertex_count();
    for (const std::uint32_t corner : indices(corners.bufferView, corners.byteOffset, corners.count,
                                              corners.componentType, points.size() / 3, "triangles"))
      mesh.polygon_corners.push_back(checked_u32(base + corner, "vertices"));
    mesh.polygon_sizes.insert(mesh.polygon_sizes.end(), corners.count / 3, 3);
    mesh.points.insert(mesh.points.end(), points.begin(), points.end());
    // glTF counts v downwards.
    if (const auto uvs = primitive.attributes.find("TEXCOORD_0"); uvs != primitive.attributes.end())
      for (const float uv : floats(uvs->second, 2, points.size() / 3, "texture coordinates"))
        mesh.uvs.push_back(mesh.uvs.size() % 2 == 0 ? uv : 1 - uv);
  }
  if (mesh.uvs.size() / 2 == mesh.vertex_count())
    mesh.uv_corners = mesh.polygon_corners;
  else
    mesh.uvs.clear();
  return mesh;
}

}  // namespace fb::bake
