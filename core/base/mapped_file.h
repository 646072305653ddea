#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace fb {

// The bytes of a file for the life of this object: mapped read-only and shared between processes, or read into memory
// where mapping is not possible, such as a pipe. Fails as read_file does. Truncating a mapped file is not allowed (the
// system kills processes that read beyond the new end); replacing it by renaming, as AtomicFile does, is.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path, std::uint64_t limit = UINT64_MAX);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
  std::vector<std::byte> buffer_;  // empty if mapped
};

}  // namespace fb
