// Whole files in, whole files out: a file that is written appears under its name complete or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace fb {

// The bytes of a file; fails with its path: not_found if it is missing, io if it is a directory or unreadable, limit if
// it is larger than that.
std::vector<std::byte> read_file(const std::filesystem::path& path, std::uint64_t limit = UINT64_MAX);

// That a file is larger than read_file or its like may take.
[[noreturn]] void fail_too_large(const std::filesystem::path& path, std::uint64_t limit);

// Makes a folder, and those it lies in, unless it is there; fails with its path and the system's reason.
void make_folder(const std::filesystem::path& path);

// Writes to "<path>.partial-<pid>" beside the target and renames it on commit(); the destructor removes what was not
// committed. Fails with the path and the system's reason (disk full, no such folder, no permission), and on what is
// there already but no regular file, such as a device.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  // Flushes to the disk, calls check(path of the temporary file), if there is one, and renames; the file is there when
  // this returns. A check that throws leaves the target as it was.
  void commit(const std::function<void(const std::filesystem::path&)>& check = {});

 private:
  [[noreturn]] void fail_here(const char* what);
  std::filesystem::path path_, partial_;
  std::FILE* file_ = nullptr;
};

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace fb
