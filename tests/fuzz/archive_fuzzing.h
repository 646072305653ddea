// Archives with valid checksums from arbitrary bytes, so that fuzzing reaches the code behind the checksums.
#pragma once

#include <algorithm>
#include <cstring>

#include "archive_editor.h"
#include "base/status.h"

namespace fuzz {

using fb::Bytes;

template <class T>
T load(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Corrects signature, version, sizes and checksums. Sections follow each other by their stored sizes; the last extends
// to the end.
inline Bytes with_valid_checksums(Bytes bytes) {
  using namespace fb::archive;
  using fb::patch;
  if (bytes.size() < header_bytes) return bytes;
  std::memcpy(bytes.data(), archive_signature, sizeof archive_signature);
  patch(bytes, 8, archive_major);
  const auto count = load<std::uint32_t>(bytes, 12) % (max_sections + 1);
  patch(bytes, 12, std::uint32_t(count));
  const std::size_t table = fb::table_at(count, 0), begin = table + checksum_bytes;
  if (bytes.size() < begin + checksum_bytes) return bytes;
  patch(bytes, 16, std::uint64_t(bytes.size()));
  std::size_t at = begin;
  const std::size_t end = bytes.size() - checksum_bytes;
  for (std::size_t row = 0; row < count; ++row) {
    const std::size_t here = fb::table_at(row, 0);
    std::uint64_t size = load<std::uint64_t>(bytes, here + 48);
    if (size > end - at || row + 1 == count) size = end - at;
    patch(bytes, here + 40, std::uint64_t(at));
    patch(bytes, here + 48, size);
    if (load<std::uint32_t>(bytes, here + 36) == 0) patch(bytes, here + 56, size);
    patch(bytes, here + 64, fb::hash64(std::span(bytes).subspan(at, size)));
    at += size;
  }
  return fb::sealed(std::move(bytes));
}

#ifdef FB_FUZZ
extern "C" std::size_t LLVMFuzzerMutate(unsigned char* data, std::size_t size, std::size_t max_size);

// Changes the decompressed contents of one section of a whole archive, or any bytes of what is none.
inline std::size_t mutate(unsigned char* data, std::size_t size, std::size_t max_size, unsigned seed) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  try {
    if (seed % 8 == 0) return LLVMFuzzerMutate(data, size, max_size);
    fb::ArchiveEditor editor(with_valid_checksums({first, first + size}), std::uint64_t(1) << 24);
    if (editor.sections.empty()) return LLVMFuzzerMutate(data, size, max_size);
    fb::ArchiveEditor::Section& section = editor.sections[seed / 8 % editor.sections.size()];
    Bytes contents = section.stored;
    const std::size_t length = contents.size();
    contents.resize(length + length / 8 + 64);
    contents.resize(LLVMFuzzerMutate(reinterpret_cast<unsigned char*>(contents.data()), length, contents.size()));
    section.set(std::move(contents));
    const Bytes changed = editor.bytes();
    if (changed.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
    std::memcpy(data, changed.data(), changed.size());
    return changed.size();
  } catch (const fb::Error&) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
}
#endif

}  // namespace fuzz
