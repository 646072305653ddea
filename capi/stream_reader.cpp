#include "stream_reader.h"

#include <algorithm>

#include "archive/container/container_reader.h"

namespace fb::capi {
namespace {

constexpr std::uint64_t block_bytes = std::uint64_t(1) << 20;  // read at once

// Appends bytes of the stream until there are `size` in all; false if it ends before.
bool read_up_to(std::uint64_t size, fb_read read, void* user, std::pmr::vector<std::byte>& bytes) {
  while (bytes.size() < size) {
    const std::size_t before = bytes.size();
    const std::uint64_t wanted = std::min(size - before, block_bytes);
    bytes.resize(before + wanted);
    const std::int64_t got = read(user, bytes.data() + before, wanted);
    if (got < 0) fail(Status::io, "reading the stream failed at byte %zu", before);
    if (static_cast<std::uint64_t>(got) > wanted)
      fail(Status::invalid_argument, "the stream's read returned %lld for %llu bytes", static_cast<long long>(got),
           static_cast<unsigned long long>(wanted));
    bytes.resize(before + static_cast<std::size_t>(got));
    if (got == 0) return false;
  }
  return true;
}

}  // namespace

std::pmr::vector<std::byte> read_stream(fb_read read, void* user, std::uint64_t limit, MemoryBudget& budget) {
  std::pmr::vector<std::byte> bytes(&budget);
  if (!read_up_to(archive::header_bytes, read, user, bytes)) return bytes;
  const std::uint64_t size = archive::archive_size(bytes);
  if (size > limit)
    fail(Status::limit, "the archive has %llu bytes, more than the limit of %llu",
         static_cast<unsigned long long>(size), static_cast<unsigned long long>(limit));
  bytes.reserve(size);
  read_up_to(size, read, user, bytes);
  return bytes;
}

}  // namespace fb::capi
