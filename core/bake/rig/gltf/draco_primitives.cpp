#include "bake/rig/gltf/draco_primitives.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <tiny_gltf.h>

#include <cstring>
#include <new>
#include <span>

#include "bake/rig/gltf/gltf_mesh.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

constexpr const char* draco_extension = "KHR_draco_mesh_compression";
constexpr std::size_t most_draco_bytes = std::size_t{1} << 31;
// Vertices and triangles that a byte of compressed data stands for at most: beyond what regular grids come to.
constexpr std::size_t most_elements_a_byte = 1024;
constexpr int most_attributes = 32, most_components = 16;

// What the file says of a primitive. Draco allocates by the counts in its data without checking them: the decoders
// below fail before it does, unless they are those of the file.
struct DeclaredMesh {
  std::size_t vertices = 0, triangles = 0;
};

template <class Decoder>
class BoundedMeshDecoder : public Decoder {
 public:
  explicit BoundedMeshDecoder(DeclaredMesh declared) : declared_(declared) {}

 protected:
  bool DecodeAllAttributes() override {
    const draco::PointCloud& cloud = *this->point_cloud();
    if (cloud.num_points() != declared_.vertices || cloud.num_attributes() > most_attributes) return false;
    for (int a = 0; a < cloud.num_attributes(); ++a)
      if (cloud.attribute(a)->num_components() > most_components) return false;
    return Decoder::DecodeAllAttributes();
  }

  DeclaredMesh declared_;
};

class BoundedEdgebreaker final : public BoundedMeshDecoder<draco::MeshEdgebreakerDecoder> {
 public:
  using BoundedMeshDecoder::BoundedMeshDecoder;

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer peek = *buffer();
    std::uint32_t vertices = 0, faces = 0, symbols = 0, splits = 0;
    std::uint8_t attribute_data = 0;
    return draco::DecodeVarint(&vertices, &peek) && draco::DecodeVarint(&faces, &peek) &&
           peek.Decode(&attribute_data) && draco::DecodeVarint(&symbols, &peek) &&
           draco::DecodeVarint(&splits, &peek) && vertices <= declared_.vertices && faces <= declared_.triangles &&
           attribute_data <= most_attributes && symbols <= faces && splits <= faces &&
           MeshEdgebreakerDecoder::DecodeConnectivity();
  }
};

class BoundedSequential final : public BoundedMeshDecoder<draco::MeshSequentialDecoder> {
 public:
  using BoundedMeshDecoder::BoundedMeshDecoder;

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer peek = *buffer();
    std::uint32_t faces = 0, points = 0;
    return draco::DecodeVarint(&faces, &peek) && draco::DecodeVarint(&points, &peek) && faces <= declared_.triangles &&
           points == declared_.vertices && MeshSequentialDecoder::DecodeConnectivity();
  }
};

template <class Decoder>
void decode_by(std::span<const unsigned char> bytes, DeclaredMesh declared, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Decoder decoder(declared);
  try {
    if (!decoder.Decode({}, &buffer, &mesh).ok())
      fail(Status::bad_data, "its Draco data cannot be decoded into %zu vertices and at most %zu triangles",
           declared.vertices, declared.triangles);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail(Status::bad_data, "its Draco data cannot be decoded: %s", error.what());
  }
}

// By Draco's header: "DRACO", version, type of geometry, method.
void decode_mesh(std::span<const unsigned char> bytes, DeclaredMesh declared, draco::Mesh& mesh) {
  if (bytes.size() < 11 || std::memcmp(bytes.data(), "DRACO", 5) != 0 || bytes[7] != draco::TRIANGULAR_MESH)
    fail(Status::bad_data, "its Draco data is none, or no mesh");
  if (bytes[5] != 2 || bytes[6] < 2)
    fail(Status::unsupported, "its Draco data is of version %d.%d; 2.2 is read", bytes[5], bytes[6]);
  if (declared.vertices / most_elements_a_byte > bytes.size() ||
      declared.triangles / most_elements_a_byte > bytes.size())
    fail(Status::bad_data, "%zu bytes of Draco data cannot hold %zu vertices and %zu triangles", bytes.size(),
         declared.vertices, declared.triangles);
  if (bytes[8] == draco::MESH_EDGEBREAKER_ENCODING)
    decode_by<BoundedEdgebreaker>(bytes, declared, mesh);
  else if (bytes[8] == draco::MESH_SEQUENTIAL_ENCODING)
    decode_by<BoundedSequential>(bytes, declared, mesh);
  else
    fail(Status::bad_data, "its Draco data has the unknown method %d", bytes[8]);
}

template <class Number>
void append_values(const draco::PointAttribute& from, std::uint32_t points, int width, std::vector<unsigned char>& to) {
  std::vector<Number> values(static_cast<std::size_t>(width));
  for (draco::PointIndex point(0); point < points; ++point) {
    if (!from.ConvertValue<Number>(from.mapped_index(point), static_cast<std::int8_t>(width), values.data()))
      fail(Status::bad_data, "an attribute of its Draco data has no value of vertex %u", point.value());
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    to.insert(to.end(), bytes, bytes + values.size() * sizeof(Number));
  }
}

// Values as an accessor of the file has them.
std::vector<unsigned char> values_of(const draco::PointAttribute& from, std::uint32_t points,
                                     const tinygltf::Accessor& as) {
  const int width = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(as.type));
  if (width < 1 || width > most_components) fail(Status::bad_data, "an accessor of its Draco data has no type");
  const bool floats = from.data_type() == draco::DT_FLOAT32 || from.data_type() == draco::DT_FLOAT64;
  if (floats && as.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    fail(Status::bad_data, "an attribute of its Draco data has floats, and its accessor integers");
  if (from.data_type() == draco::DT_BOOL)  // Draco would read its bytes as C++ truth values, whatever they are
    fail(Status::bad_data, "an attribute of its Draco data has truth values, which glTF does not have");
  std::vector<unsigned char> values;
  switch (as.componentType) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      append_values<float>(from, points, width, values);
      break;
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      append_values<std::int8_t>(from, points, width, values);
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      append_values<std::uint8_t>(from, points, width, values);
      break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      append_values<std::int16_t>(from, points, width, values);
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      append_values<std::uint16_t>(from, points, width, values);
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      append_values<std::uint32_t>(from, points, width, values);
      break;
    default:
      fail(Status::bad_data, "an accessor of its Draco data has the unknown component type %d", as.componentType);
  }
  return values;
}

// Decodes one primitive after the other of a model.
class DracoPrimitives {
 public:
  explicit DracoPrimitives(tinygltf::Model& model) : model_(model) {}

  void decode(tinygltf::Primitive& primitive, const tinygltf::Value& extension) {
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES)
      fail(Status::unsupported, "its Draco data are no list of triangles (mode %d)", primitive.mode);
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) fail(Status::bad_data, "has Draco data and no positions");
    const tinygltf::Accessor& positions = accessor(position->second);
    const std::size_t corners = accessor(primitive.indices).count;
    draco::Mesh mesh;
    decode_mesh(view(extension), {positions.count, corners / 3}, mesh);
    take_triangles(primitive, mesh);
    const tinygltf::Value& ids = extension.Get("attributes");
    if (!ids.IsObject()) fail(Status::bad_data, "its Draco data has no attributes");
    for (const std::string& name : ids.Keys()) {
      const auto at = primitive.attributes.find(name);
      if (at == primitive.attributes.end()) continue;
      const int id = ids.Get(name).IsInt() ? ids.Get(name).GetNumberAsInt() : -1;
      const draco::PointAttribute* from =
          id < 0 ? nullptr : mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
      if (!from) fail(Status::bad_data, "its Draco data has no attribute %d for %s", id, name.c_str());
      tinygltf::Accessor made = accessor(at->second);
      if (made.count != mesh.num_points())
        fail(Status::bad_data, "its Draco data has %u vertices, its %s %zu", mesh.num_points(), name.c_str(),
             made.count);
      at->second = add(std::move(made), values_of(*from, mesh.num_points(), accessor(at->second)));
    }
  }

 private:
  const tinygltf::Accessor& accessor(int index) const {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.accessors.size())
      fail(Status::bad_data, "has Draco data, and accessor %d of %zu", index, model_.accessors.size());
    return model_.accessors[static_cast<std::size_t>(index)];
  }

  std::span<const unsigned char> view(const tinygltf::Value& extension) const {
    const tinygltf::Value& number = extension.IsObject() ? extension.Get("bufferView") : extension;
    const int index = number.IsInt() ? number.GetNumberAsInt() : -1;
    if (index < 0 || static_cast<std::size_t>(index) >= model_.bufferViews.size())
      fail(Status::bad_data, "its Draco data lies in buffer view %d of %zu", index, model_.bufferViews.size());
    const tinygltf::BufferView& found = model_.bufferViews[static_cast<std::size_t>(index)];
    if (found.buffer < 0 || static_cast<std::size_t>(found.buffer) >= model_.buffers.size())
      fail(Status::bad_data, "its Draco data lies in buffer %d of %zu", found.buffer, model_.buffers.size());
    const std::vector<unsigned char>& data = model_.buffers[static_cast<std::size_t>(found.buffer)].data;
    if (checked_add(found.byteOffset, found.byteLength, "bytes") > data.size())
      fail(Status::bad_data, "its Draco data runs past the end of its buffer");
    return std::span(data).subspan(found.byteOffset, found.byteLength);
  }

  void take_triangles(tinygltf::Primitive& primitive, const draco::Mesh& mesh) {
    std::vector<unsigned char> corners;
    for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
      for (const draco::PointIndex& point : mesh.face(face)) {
        const std::uint32_t vertex = point.value();
        const auto* bytes = reinterpret_cast<const unsigned char*>(&vertex);
        corners.insert(corners.end(), bytes, bytes + sizeof vertex);
      }
    tinygltf::Accessor made = accessor(primitive.indices);
    made.type = TINYGLTF_TYPE_SCALAR;
    made.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    made.count = 3 * std::size_t(mesh.num_faces());
    primitive.indices = add(std::move(made), std::move(corners));
  }

  // A new accessor of values in a buffer of their own.
  int add(tinygltf::Accessor made, std::vector<unsigned char> values) {
    decoded_ = checked_add(decoded_, values.size(), "bytes");
    if (decoded_ > most_draco_bytes) fail(Status::limit, "it and those before it are more than 2 GiB");
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(model_.buffers.size());
    view.byteLength = values.size();
    made.bufferView = static_cast<int>(model_.bufferViews.size());
    made.byteOffset = 0;
    made.sparse.isSparse = false;
    model_.buffers.emplace_back().data = std::move(values);
    model_.bufferViews.push_back(std::move(view));
    model_.accessors.push_back(std::move(made));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  tinygltf::Model& model_;
  std::size_t decoded_ = 0;
};

}  // namespace

void decode_draco_primitives(tinygltf::Model& model) {
  DracoPrimitives primitives(model);
  for (std::size_t m = 0; m < model.meshes.size(); ++m)
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      const auto found = primitive.extensions.find(draco_extension);
      if (found == primitive.extensions.end()) continue;
      const tinygltf::Value extension = found->second;
      with_context(format("mesh %zu (\"%s\"), primitive %zu", m, shown_name(model.meshes[m].name), p),
                   [&] { primitives.decode(primitive, extension); });
      primitive.extensions.erase(found);
    }
}

}  // namespace fb::bake
