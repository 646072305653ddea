// Runs a fuzz target on every file of the given folders, for builds without libFuzzer: a regression test of all inputs
// found by fuzzing. Fails if one takes more than a second.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "base/file.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size);

int main(int count, char** arguments) {
  std::size_t files = 0, slow = 0;
  for (int a = 1; a < count; ++a) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(arguments[a]))
      if (entry.is_regular_file()) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const auto& path : paths) {
      const auto bytes = fb::read_file(path);
      const auto start = std::chrono::steady_clock::now();
      LLVMFuzzerTestOneInput(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      if (seconds > 1) std::printf("%s: %.1f seconds\n", path.c_str(), seconds), ++slow;
      ++files;
    }
  }
  std::printf("%zu inputs\n", files);
  return files == 0 || slow > 0;
}
