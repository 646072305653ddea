// A folder for fuzz targets whose code reads files: in memory if possible, one a process, gone afterwards.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/status.h"

namespace fuzz {

inline const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const std::filesystem::path shared = "/dev/shm";
    const auto base = std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path();
    auto made = base / ("fb-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] { std::filesystem::remove_all(folder()); });
    return made;
  }();
  return path;
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
