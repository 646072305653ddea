#include "bake/train/checkpoint.h"

#include <cstring>
#include <span>

#include "base/file.h"
#include "base/hash.h"

namespace fb::bake {
namespace {

// Layout, in native byte order: key, step, number of arrays, their sizes, their floats, XXH64 of all before.
using Word = std::uint64_t;

}  // namespace

void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  std::vector<Word> head = {checkpoint.key, checkpoint.step, checkpoint.arrays.size()};
  for (const auto& array : checkpoint.arrays) head.push_back(array.size());
  Word sum = hash64_of<Word>(head);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(head)));
  for (const auto& array : checkpoint.arrays) {
    file.write(std::as_bytes(std::span(array)));
    sum = hash64_of<float>(array, sum);
  }
  file.write(std::as_bytes(std::span(&sum, 1)));
  file.commit();
}

std::optional<Checkpoint> load_checkpoint(const std::filesystem::path& path, std::uint64_t key) {
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  const std::vector<std::byte> bytes = read_file(path);
  std::size_t at = 0;
  const auto word = [&](Word& value) {
    if (bytes.size() - at < sizeof value) return false;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return true;
  };
  Checkpoint checkpoint;
  Word arrays = 0, sum = 0;
  if (!word(checkpoint.key) || checkpoint.key != key || !word(checkpoint.step) || !word(arrays)) return std::nullopt;
  std::vector<Word> sizes;
  for (Word i = 0, size = 0; i < arrays; ++i) {
    if (!word(size)) return std::nullopt;
    sizes.push_back(size);
  }
  Word expected = hash64(std::span(bytes).first(at));
  for (const Word size : sizes) {
    if (size > (bytes.size() - at) / sizeof(float)) return std::nullopt;
    std::vector<float> array(size);
    if (size > 0) std::memcpy(array.data(), bytes.data() + at, size * sizeof(float));
    at += size * sizeof(float);
    expected = hash64_of<float>(array, expected);
    checkpoint.arrays.push_back(std::move(array));
  }
  if (!word(sum) || sum != expected || at != bytes.size()) return std::nullopt;
  return checkpoint;
}

}  // namespace fb::bake
