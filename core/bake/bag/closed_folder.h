// A folder from anyone, of which nothing outside is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/open_descriptor.h"
#include "base/progress.h"

namespace fb::bake {

inline constexpr std::size_t read_piece_bytes = std::size_t{1} << 20;

class ClosedFolder {
 public:
  enum class Kind { file, folder, link, other };
  struct Entry {
    std::string path;  // in the folder, with slashes; bytes as the system has them
    Kind kind = Kind::other;
    std::uint64_t bytes = 0;  // of a file
  };
  using Complain = std::function<void(const std::string& path, const std::string& reason)>;
  using Take = std::function<void(std::span<const std::byte>)>;

  // The folder itself may be a link. Fails with not_found where there is none, with io where it cannot be read.
  explicit ClosedFolder(std::filesystem::path folder);

  const std::filesystem::path& path() const { return path_; }
  // All that is in it, sorted by path; no link is followed. `complain` is told what cannot be read. Fails with limit on
  // more than a million entries.
  std::vector<Entry> list(const Complain& complain, Progress& progress) const;
  // Hands over the bytes of a file, piece by piece. Fails with io, naming the reason and not the path, on a link in the
  // path, on what is no regular file, and where it cannot be read. Thread-safe.
  void read(const std::string& path, const Take& take) const;
  // The same as a whole, of at most `most` bytes; fails with limit on more.
  std::string read_text(const std::string& path, std::uint64_t most) const;

 private:
  OpenDescriptor open(const std::string& path, int flags) const;

  std::filesystem::path path_;
  OpenDescriptor folder_;
};

}  // namespace fb::bake
