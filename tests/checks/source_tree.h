// The text files of the source tree, as the checks on the tree itself see them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace checks {

struct SourceFile {
  std::string path;  // from the root of the tree, with slashes
  std::string text;

  std::string name() const { return path.substr(path.rfind('/') + 1); }
  // With the dot; "" if there is none.
  std::string extension() const { return std::filesystem::path(path).extension().string(); }
  bool is_code() const;  // C or C++
};

// Sorted by path.
using SourceTree = std::vector<SourceFile>;

// Code, scripts, build files and papers; build folders and hidden ones are left out.
SourceTree read_source_tree(const std::filesystem::path& root);

}  // namespace checks
