// Feeds arbitrary bytes to the reader of archives of format 0.2, which `facebaker pack` converts: as they are, and with
// version and checksums corrected. What it accepts must be written and read again.
#include <vector>

#include "archive/migrate/version_0_2.h"
#include "archive/writer.h"
#include "archive_fuzzing.h"

namespace {

constexpr fb::archive::FormatVersion version = {0, 2};
constexpr std::uint64_t max_bytes = std::uint64_t(16) << 20;

void convert(const fb::Bytes& bytes) {
  try {
    const fb::archive::Archive old = fb::archive::read_version_0_2(bytes, {max_bytes});
    fb::archive::read_archive(fb::archive::write_archive(old.model, {}, {}));
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  const fb::Bytes bytes(first, first + size);
  convert(bytes);
  convert(fuzz::with_valid_checksums(bytes, version));
  return 0;
}

#ifdef FB_FUZZ
extern "C" std::size_t LLVMFuzzerCustomMutator(unsigned char* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return fuzz::mutate(data, size, max_size, seed, version);
}
#endif
