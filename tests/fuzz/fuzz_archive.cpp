// Feeds arbitrary bytes to the archive reader: as they are, and with all checksums corrected so that the code behind
// them is reached. Accepted archives are evaluated.
#include <cstring>
#include <vector>

#include "archive/container/container_layout.h"
#include "archive/reader.h"
#include "base/hash.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace {

constexpr std::uint64_t max_bytes = std::uint64_t(16) << 20;

using Bytes = std::vector<std::byte>;

template <class T>
T load(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class T>
void store(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

// Corrects signature, sizes and checksums. Sections follow each other by their stored sizes; the last extends to the
// end.
Bytes with_valid_checksums(Bytes bytes) {
  using namespace fb;
  using namespace fb::archive;
  using namespace fb::runtime;
  if (bytes.size() < header_bytes) return bytes;
  std::memcpy(bytes.data(), archive_signature, sizeof archive_signature);
  const auto count = load<std::uint32_t>(bytes, 12) % (max_sections + 1);
  store(bytes, 12, std::uint32_t(count));
  const std::size_t table = header_bytes + count * table_row_bytes, begin = table + checksum_bytes;
  if (bytes.size() < begin + checksum_bytes) return bytes;
  store(bytes, 16, std::uint64_t(bytes.size()));
  std::size_t at = begin;
  const std::size_t end = bytes.size() - checksum_bytes;
  for (std::size_t row = 0; row < count; ++row) {
    const std::size_t here = header_bytes + row * table_row_bytes;
    std::uint64_t size = load<std::uint64_t>(bytes, here + 32);
    if (size > end - at || row + 1 == count) size = end - at;
    store(bytes, here + 24, std::uint64_t(at));
    store(bytes, here + 32, size);
    if (load<std::uint32_t>(bytes, here + 20) == 0) store(bytes, here + 40, size);
    store(bytes, here + 48, hash64(std::span(bytes).subspan(at, size)));
    at += size;
  }
  store(bytes, table, hash64(std::span(bytes).first(table)));
  store(bytes, end, hash64(std::span(bytes).first(end)));
  return bytes;
}

void read_and_evaluate(const Bytes& bytes) {
  try {
    const fb::archive::Archive archive = fb::archive::read_archive(bytes, {max_bytes});
    const fb::runtime::Evaluator face(archive.model);
    if (face.bytes() > max_bytes) return;
    fb::runtime::Workspace workspace(face);
    std::vector<float> controls, positions(archive.model.rest.points.size());
    for (const fb::Control& control : archive.model.schema.controls) controls.push_back(control.maximum);
    face.evaluate(controls.data(), positions.data(), workspace);
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();  // every refusal has a message
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  const Bytes bytes(first, first + size);
  read_and_evaluate(bytes);
  read_and_evaluate(with_valid_checksums(bytes));
  return 0;
}
