// Feeds arbitrary bytes to the glTF rig, in memory: as they are, and with the sizes of a .glb corrected so that the
// JSON and the buffer behind them are reached. Joints are ignored, and controls, and
// broken parts left out. Accepted rigs are posed. Files beside
// are refused: there are none in memory.
#include <algorithm>
#include <span>
#include <vector>

#include "bake/rig/gltf/gltf_rig.h"
#include "fuzz_folder.h"

namespace {

using Bytes = std::vector<unsigned char>;

constexpr std::size_t header = 12, chunk_header = 8, start = header + chunk_header;

std::uint32_t word(const Bytes& bytes, std::size_t at) {
  std::uint32_t value;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

void set_word(Bytes& bytes, std::size_t at, std::size_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  std::memcpy(&bytes[at], &number, sizeof number);
}

// A .glb of two chunks: the first as long as it says, as far as possible; the second to the end.
Bytes with_valid_sizes(Bytes bytes) {
  while (bytes.size() % 4 != 0) bytes.push_back(' ');
  if (bytes.size() < start + chunk_header) return bytes;
  std::memcpy(bytes.data(), "glTF\2\0\0\0", 8);
  set_word(bytes, 8, bytes.size());
  const std::size_t json = std::min<std::size_t>(word(bytes, 12) / 4 * 4, bytes.size() - start - chunk_header);
  set_word(bytes, 12, json);
  std::memcpy(&bytes[16], "JSON", 4);
  set_word(bytes, start + json, bytes.size() - start - json - chunk_header);
  std::memcpy(&bytes[start + json + 4], "BIN\0", 4);
  return bytes;
}

void open_and_pose(const Bytes& bytes) {
  using fb::bake::JointUse;
  for (const auto joints : {JointUse::ignored, JointUse::controls, JointUse::automatic})
    fuzz::expect_message([&] {
      const fb::bake::GltfOptions options = {joints, {}, joints == JointUse::automatic};
      const auto rig = fb::bake::open_gltf_rig(std::as_bytes(std::span(bytes)), "fuzzed", options);
      std::vector<float> pose, points(rig->rest().points.size());
      for (const fb::Control& control : rig->schema().controls) pose.push_back(control.maximum);
      rig->evaluate(pose, 1, points);
    });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const Bytes bytes(data, data + size);
  open_and_pose(bytes);
  if (size >= 4 && std::memcmp(data, "glTF", 4) == 0) open_and_pose(with_valid_sizes(bytes));
  return 0;
}

#ifdef FB_FUZZ
extern "C" std::size_t LLVMFuzzerMutate(unsigned char* data, std::size_t size, std::size_t max_size);

// Changes one chunk of a .glb, or anything.
extern "C" std::size_t LLVMFuzzerCustomMutator(unsigned char* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  Bytes bytes = with_valid_sizes({data, data + size});
  if (seed % 4 == 0 || bytes.size() < start + chunk_header || bytes.size() + 16 > max_size)
    return LLVMFuzzerMutate(data, size, max_size);
  const std::size_t json = word(bytes, 12), buffer = start + json + chunk_header;
  const bool first = seed % 4 != 1;  // the JSON, more often
  Bytes chunk(bytes.begin() + (first ? start : buffer), first ? bytes.begin() + (start + json) : bytes.end());
  const std::size_t length = chunk.size(), room = length + (max_size - 16 - bytes.size());
  chunk.resize(std::max<std::size_t>(room, 1));
  chunk.resize(LLVMFuzzerMutate(chunk.data(), length, chunk.size()));
  while (chunk.size() % 4 != 0) chunk.push_back(' ');
  Bytes changed(bytes.begin(), bytes.begin() + (first ? start : buffer));
  changed.insert(changed.end(), chunk.begin(), chunk.end());
  if (first) {
    changed.insert(changed.end(), bytes.begin() + (start + json), bytes.end());
    set_word(changed, 12, chunk.size());
  }
  changed = with_valid_sizes(std::move(changed));
  std::copy(changed.begin(), changed.end(), data);
  return changed.size();
}
#endif
