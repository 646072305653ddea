#include "bake/rig/gltf/meshopt_views.h"

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "base/checked.h"

namespace fb::bake {
namespace {

constexpr std::array<const char*, 2> meshopt_extensions = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
// A block of vertices takes a byte or more for each 1,024 of theirs, an index less.
constexpr std::size_t most_expansion = 1024;
constexpr std::size_t most_decoded_bytes = std::size_t{1} << 31;

// What the extension says of a view: EXT_meshopt_compression, "Specifying compressed views".
struct CompressedView {
  std::size_t buffer = 0, offset = 0, bytes = 0, stride = 0, count = 0;
  std::string mode, filter = "NONE";
};

std::size_t whole_member(const tinygltf::Value& from, const char* key, std::optional<std::size_t> otherwise = {}) {
  if (!from.Has(key) && otherwise) return *otherwise;
  const tinygltf::Value& value = from.Get(key);
  const double number = value.IsNumber() ? value.GetNumberAsDouble() : -1;
  if (!(number >= 0 && number < 0x1p32) || number != static_cast<double>(static_cast<std::uint64_t>(number)))
    fail(Status::bad_data, "its %s is no whole number below 2^32", key);
  return static_cast<std::size_t>(number);
}

CompressedView read_view(const tinygltf::Value& from) {
  if (!from.IsObject()) fail(Status::bad_data, "the extension is no object");
  CompressedView view;
  view.buffer = whole_member(from, "buffer");
  view.offset = whole_member(from, "byteOffset", 0);
  view.bytes = whole_member(from, "byteLength");
  view.stride = whole_member(from, "byteStride");
  view.count = whole_member(from, "count");
  if (!from.Get("mode").IsString()) fail(Status::bad_data, "its mode is no text");
  view.mode = from.Get("mode").Get<std::string>();
  if (from.Has("filter") && from.Get("filter").IsString()) view.filter = from.Get("filter").Get<std::string>();
  return view;
}

// What the decoder takes for granted: the same document, "JSON schema updates".
void check_sizes(const CompressedView& view) {
  const bool attributes = view.mode == "ATTRIBUTES", triangles = view.mode == "TRIANGLES";
  if (!attributes && !triangles && view.mode != "INDICES")
    fail(Status::bad_data, "its mode is \"%s\", none of ATTRIBUTES, TRIANGLES and INDICES", view.mode.c_str());
  if (attributes ? view.stride == 0 || view.stride % 4 != 0 || view.stride > 256 : view.stride != 2 && view.stride != 4)
    fail(Status::bad_data, "its byteStride is %zu", view.stride);
  if (view.count == 0 || (triangles && view.count % 3 != 0)) fail(Status::bad_data, "its count is %zu", view.count);
  const bool octahedral = view.filter == "OCTAHEDRAL", quaternion = view.filter == "QUATERNION";
  if (!octahedral && !quaternion && view.filter != "EXPONENTIAL" && view.filter != "NONE")
    fail(Status::unsupported, "its filter \"%s\" is not read", view.filter.c_str());
  const bool wrong = octahedral ? view.stride != 4 && view.stride != 8 : quaternion && view.stride != 8;
  if (view.filter != "NONE" && (!attributes || wrong))
    fail(Status::bad_data, "its filter %s does not go with mode %s and a byteStride of %zu", view.filter.c_str(),
         view.mode.c_str(), view.stride);
}

// The first byte of compressed data says of what kind it is and in which version.
void check_version(const CompressedView& view, unsigned char first) {
  const unsigned kind = view.mode == "ATTRIBUTES" ? 0xa0 : view.mode == "TRIANGLES" ? 0xe0 : 0xd0;
  const unsigned newest = view.mode == "ATTRIBUTES" ? 0 : 1;
  if ((first & 0xf0u) != kind) fail(Status::bad_data, "its data is not of mode %s", view.mode.c_str());
  if ((first & 0x0fu) > newest)
    fail(Status::unsupported, "its data is of version %u of the codec; up to %u is read", first & 0x0fu, newest);
}

std::vector<unsigned char> decode(const CompressedView& view, std::span<const unsigned char> from) {
  std::vector<unsigned char> to(view.count * view.stride);
  int failed = 0;
  if (view.mode == "ATTRIBUTES")
    failed = meshopt_decodeVertexBuffer(to.data(), view.count, view.stride, from.data(), from.size());
  else if (view.mode == "TRIANGLES")
    failed = meshopt_decodeIndexBuffer(to.data(), view.count, view.stride, from.data(), from.size());
  else
    failed = meshopt_decodeIndexSequence(to.data(), view.count, view.stride, from.data(), from.size());
  if (failed != 0) fail(Status::bad_data, "its data cannot be decoded");
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to.data(), view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(to.data(), view.count, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(to.data(), view.count, view.stride);
  return to;
}

// `left`: bytes that may still be decoded.
std::vector<unsigned char> decode(const tinygltf::Model& model, const tinygltf::Value& extension, std::size_t& left) {
  const CompressedView view = read_view(extension);
  check_sizes(view);
  if (view.buffer >= model.buffers.size())
    fail(Status::bad_data, "its data lies in buffer %zu of %zu", view.buffer, model.buffers.size());
  const std::vector<unsigned char>& data = model.buffers[view.buffer].data;
  if (view.bytes == 0 || checked_add(view.offset, view.bytes, "bytes") > data.size())
    fail(Status::bad_data, "its data runs past the end of its buffer");
  const std::size_t decoded = checked_multiply(view.count, view.stride, "bytes");
  if (decoded / most_expansion > view.bytes)
    fail(Status::bad_data, "%zu bytes cannot hold %zu elements", view.bytes, view.count);
  if (decoded > left) fail(Status::limit, "it and those before it are more than 2 GiB");
  left -= decoded;
  check_version(view, data[view.offset]);
  return decode(view, std::span(data).subspan(view.offset, view.bytes));
}

}  // namespace

bool is_meshopt_extension(const std::string& name) {
  return std::ranges::find(meshopt_extensions, name) != meshopt_extensions.end();
}

void decode_meshopt_views(tinygltf::Model& model) {
  std::size_t left = most_decoded_bytes;
  for (std::size_t v = 0; v < model.bufferViews.size(); ++v)
    for (const char* name : meshopt_extensions) {
      const auto found = model.bufferViews[v].extensions.find(name);
      if (found == model.bufferViews[v].extensions.end()) continue;
      with_context(format("buffer view %zu, %s", v, name), [&] {
        tinygltf::Buffer decoded;
        decoded.data = decode(model, found->second, left);
        tinygltf::BufferView& view = model.bufferViews[v];
        view.buffer = static_cast<int>(model.buffers.size());
        view.byteOffset = 0;
        view.byteLength = decoded.data.size();
        view.byteStride = found->second.Get("mode").Get<std::string>() == "ATTRIBUTES"
                              ? static_cast<std::size_t>(found->second.Get("byteStride").GetNumberAsDouble())
                              : 0;
        model.buffers.push_back(std::move(decoded));
      });
      break;
    }
}

}  // namespace fb::bake
