#include "bake/rig/gltf/gltf_file.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "bake/rig/gltf/draco_primitives.h"
#include "bake/rig/gltf/files_beside.h"
#include "bake/rig/gltf/glb_chunks.h"
#include "bake/rig/gltf/loadable_file.h"
#include "bake/rig/gltf/loader_files.h"
#include "bake/rig/gltf/meshopt_views.h"
#include "base/checked.h"
#include "base/json_depth.h"

namespace fb::bake {
namespace {

// Keeps the bytes of an image in a data URI as they are. Those in a buffer view have not been checked: see view().
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

// Extensions that a file may require: those that change no geometry, of materials, textures, lights and avatars, and
// those that store geometry in ways that are read.
constexpr std::array<std::string_view, 6> harmless_extensions = {
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "VRMC_", "KHR_lights_punctual", "KHR_xmp"};
constexpr std::array<std::string_view, 5> read_extensions = {"KHR_mesh_quantization", "KHR_draco_mesh_compression",
                                                             "VRM", "EXT_mesh_gpu_instancing", "KHR_animation_pointer"};

void check_extensions(const tinygltf::Model& model) {
  for (const std::string& name : model.extensionsRequired) {
    const bool harmless = std::ranges::any_of(harmless_extensions, [&](auto begin) { return name.starts_with(begin); });
    if (!harmless && !is_meshopt_extension(name) && std::ranges::find(read_extensions, name) == read_extensions.end())
      fail(Status::unsupported, "requires the glTF extension %s, which is not read; export without it", name.c_str());
  }
}

template <class T>
float read_number(const unsigned char* at, bool normalised) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if (!normalised) return static_cast<float>(value);
  return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
}

// How a number of an accessor is read: glTF 2.0, section 3.11, and KHR_mesh_quantization.
struct NumberFormat {
  std::size_t bytes;
  float (*read)(const unsigned char* at, bool normalised);
};

NumberFormat number_format(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return {4, [](const unsigned char* at, bool) { return read_number<float>(at, false); }};
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return {1, read_number<std::int8_t>};
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return {1, read_number<std::uint8_t>};
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return {2, read_number<std::int16_t>};
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return {2, read_number<std::uint16_t>};
    default:
      return {0, nullptr};
  }
}

// Elements of an accessor without bytes of its own, which a file of a few bytes could have any number of.
constexpr std::size_t most_unstored = std::size_t{1} << 24;

// What an element of so many numbers is called in messages, and its type in files.
struct ElementType {
  std::size_t width;
  int type;
  const char* name;
};
constexpr ElementType element_types[] = {{1, TINYGLTF_TYPE_SCALAR, "floats"},
                                         {2, TINYGLTF_TYPE_VEC2, "two floats each"},
                                         {3, TINYGLTF_TYPE_VEC3, "three floats each"},
                                         {4, TINYGLTF_TYPE_VEC4, "four floats each"},
                                         {16, TINYGLTF_TYPE_MAT4, "matrices of floats"}};

const ElementType& element_type(std::size_t width) {
  return *std::ranges::find(element_types, width, &ElementType::width);
}

}  // namespace

// Unsigned integers in a buffer view.
struct GltfFile::Scalars {
  int view;
  std::size_t offset, count, width;
  int component_type;
};

GltfFile::GltfFile(std::span<const std::byte> bytes, std::optional<std::filesystem::path> folder)
    : model_(std::make_unique<tinygltf::Model>()), beside_(std::make_unique<FilesBeside>(std::move(folder))) {
  tinygltf::TinyGLTF loader;
  open_files_beside<tinygltf::FsCallbacks>(loader, *beside_);
  loader.SetImageLoader(keep_image, nullptr);
  std::string error, warning;
  const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  check_json_depth(json_of_gltf(bytes, binary));
  const auto changed = loadable_file(bytes, binary);
  if (changed) bytes = *changed;
  const auto size = checked_u32(bytes.size(), "bytes");
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
  decode_meshopt_views(*model_);
  decode_draco_primitives(*model_);
}

GltfFile::~GltfFile() = default;

std::size_t GltfFile::count(int index, const char* what) const {
  if (index < 0 || static_cast<std::size_t>(index) >= model_->accessors.size())
    fail(Status::bad_data, "no accessor %d for its %s", index, what);
  return model_->accessors[static_cast<std::size_t>(index)].count;
}

const tinygltf::Accessor& GltfFile::accessor(int index, std::size_t width, const char* what) const {
  count(index, what);  // checks the index
  const tinygltf::Accessor& found = model_->accessors[static_cast<std::size_t>(index)];
  if (found.type != element_type(width).type)
    fail(Status::unsupported, "its %s are not %s", what, element_type(width).name);
  return found;
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
  const tinygltf::Accessor& from = accessor(index, width, what);
  const NumberFormat number = number_format(from.componentType);
  if (!number.read) fail(Status::unsupported, "its %s are not %s", what, element_type(width).name);
  if (count && from.count != *count)
    fail(Status::bad_data, "has %zu %s where %zu are needed", from.count, what, *count);
  const bool stored = from.bufferView >= 0 || !(count || from.sparse.isSparse);
  std::size_t stride = 0;
  const auto data = stored ? bytes(from.bufferView, from.byteOffset, from.count, width * number.bytes, stride, what)
                           : std::span<const unsigned char>();
  if (!stored && from.count > most_unstored) fail(Status::limit, "has %zu %s without a buffer", from.count, what);
  std::vector<float> values(checked_multiply(from.count, width, what));
  for (std::size_t i = 0; stored && i < values.size(); ++i)
    values[i] = number.read(data.data() + i / width * stride + i % width * number.bytes, from.normalized);
  if (from.sparse.isSparse) overwrite_sparse(from, width, values, what);
  return values;
}

std::vector<std::uint32_t> GltfFile::sparse_elements(const tinygltf::Accessor& from, const char* what) const {
  const auto& sparse = from.sparse;
  // Offsets are of type int or size_t, by the version of the loader.
  const auto indices_offset = static_cast<std::int64_t>(sparse.indices.byteOffset);
  const auto values_offset = static_cast<std::int64_t>(sparse.values.byteOffset);
  if (sparse.count < 1 || indices_offset < 0 || values_offset < 0)
    fail(Status::bad_data, "its sparse %s have a count or an offset below zero", what);
  return indices({sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                  static_cast<std::size_t>(sparse.count), 1, sparse.indices.componentType},
                 from.count, what);
}

void GltfFile::overwrite_sparse(const tinygltf::Accessor& from, std::size_t width, std::span<float> values,
                                const char* what) const {
  const auto& sparse = from.sparse;
  const std::vector<std::uint32_t> elements = sparse_elements(from, what);
  const std::size_t count = elements.size();
  const NumberFormat number = number_format(from.componentType);
  std::size_t stride = 0;
  const auto data = bytes(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), count,
                          width * number.bytes, stride, what);
  for (std::size_t i = 0; i < count * width; ++i)
    values[elements[i / width] * width + i % width] =
        number.read(data.data() + i / width * stride + i % width * number.bytes, from.normalized);
}

std::vector<std::uint32_t> GltfFile::indices(int index, std::size_t width, std::optional<std::size_t> count,
                                             std::size_t limit, const char* what) const {
  const tinygltf::Accessor& from = accessor(index, width, what);
  if (count && from.count != *count)
    fail(Status::bad_data, "has %zu %s where %zu are needed", from.count, what, *count);
  std::vector<std::uint32_t> values;
  if (from.bufferView < 0 && from.sparse.isSparse && from.count <= most_unstored)
    values.resize(from.count * width);
  else
    values = indices({from.bufferView, from.byteOffset, from.count, width, from.componentType}, limit, what);
  if (!from.sparse.isSparse) return values;
  const std::vector<std::uint32_t> elements = sparse_elements(from, what);
  const std::vector<std::uint32_t> stored =
      indices({from.sparse.values.bufferView, static_cast<std::size_t>(from.sparse.values.byteOffset), elements.size(),
               width, from.componentType},
              limit, what);
  for (std::size_t i = 0; i < stored.size(); ++i) values[elements[i / width] * width + i % width] = stored[i];
  return values;
}

std::vector<std::uint32_t> GltfFile::indices(const Scalars& from, std::size_t limit, const char* what) const {
  const std::size_t width = from.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 1
                            : from.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                            : from.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? 4
                                                                                            : 0;
  if (width == 0) fail(Status::bad_data, "the indices of its %s are not unsigned integers", what);
  std::size_t stride = 0;
  const auto data = bytes(from.view, from.offset, from.count, from.width * width, stride, what);
  std::vector<std::uint32_t> values(from.count * from.width);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::memcpy(&values[i], data.data() + i / from.width * stride + i % from.width * width, width);
    if (values[i] >= limit) fail(Status::bad_data, "index %zu of its %s is %u of %zu", i, what, values[i], limit);
  }
  return values;
}

std::span<const std::byte> GltfFile::view(int index, const char* what) const {
  std::size_t stride = 0;
  bytes(index, 0, 1, 1, stride, what);  // checks the indices
  const std::size_t length = model_->bufferViews[static_cast<std::size_t>(index)].byteLength;
  return std::as_bytes(bytes(index, 0, 1, length, stride, what));
}

std::vector<std::byte> GltfFile::read_uri(const std::string& uri) const {
  if (auto data = decode_data_uri(uri)) return *std::move(data);
  return beside_->read(uri);
}

}  // namespace fb::bake
