// Reading and writing whole files. Writing is atomic: a file appears under its name complete or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/locked_file.h"

namespace fb {

// The bytes of a regular file. Fails as InputFile does, with limit if it has more than `limit` bytes.
std::vector<std::byte> read_file(const std::filesystem::path& path, std::uint64_t limit = UINT64_MAX);

// Creates a folder and its missing parents, durably. Fails with its path and the system's reason.
void make_folder(const std::filesystem::path& path);

// Removes a folder with everything in it. Fails with its path and the system's reason.
void remove_folder(const std::filesystem::path& path);

// Writes to "<path>.facebaker-partial" beside the target and renames it on commit(); the destructor removes an
// uncommitted file. What a killed process left under that name is removed. The target of a link is written, and a file
// that is replaced hands on its rights (replaced_file.h). Fails with the path and the system's reason (disk full, no
// permission), if another process is writing the same file, and if the target is there and no regular file.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  // Flushes to the disk, calls check(path of the temporary file), if given, renames, and syncs the folder. If it fails
  // before the rename, the target is unchanged.
  void commit(const std::function<void(const std::filesystem::path&)>& check = {});

 private:
  std::filesystem::path path_, partial_;
  std::optional<LockedFile> file_;
};

// Removes the partial files of a folder that no running process is writing.
void remove_partial_files(const std::filesystem::path& folder);

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace fb
