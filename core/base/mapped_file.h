#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace fb {

// The bytes of a file while this object lives: mapped read-only, so that processes that look at the same file share
// its pages and nothing is copied; read into memory what cannot be mapped, as a pipe. Fails as read_file does. Nobody
// may cut a mapped file short meanwhile (the system ends whoever reads beyond its new end); to replace it by renaming,
// as AtomicFile does, is safe.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path, std::uint64_t limit = UINT64_MAX);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
  std::vector<std::byte> read_;  // empty if mapped
};

}  // namespace fb
