#pragma once

#include <unistd.h>

#include <filesystem>
#include <iterator>

#include "base/status.h"

namespace fb {

// A folder of its own for one test, gone afterwards.
struct TemporaryFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / format("facebaker-file-test-%d", getpid());
  TemporaryFolder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path); }
  std::size_t entries() const {
    return std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator());
  }
};

}  // namespace fb
