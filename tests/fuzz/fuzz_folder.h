// A folder for fuzz targets whose code reads files: in memory if possible, one a process, gone afterwards.
#pragma once

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "base/status.h"

namespace fuzz {

class FuzzFolder {
 public:
  FuzzFolder() {
    const std::filesystem::path shared = "/dev/shm";
    const auto base = std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path();
    path_ = base / ("fb-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  ~FuzzFolder() {
    std::error_code failed;
    std::filesystem::remove_all(path_, failed);
  }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline const std::filesystem::path& folder() {
  static const FuzzFolder made;
  return made.path();
}

// Writes a file there, without syncing it to the disk.
inline std::filesystem::path put(const char* name, const unsigned char* data, std::size_t size) {
  const std::filesystem::path path = folder() / name;
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

// Runs work(); an Error must have a message.
template <class Work>
void expect_message(Work&& work) {
  try {
    work();
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();
  }
}

}  // namespace fuzz
