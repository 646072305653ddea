// The text files of the source tree, as the checks on the tree itself see them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
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

// What follows a preprocessor directive: "<x>" for "include" in the line "  # include <x>". Nothing if the line is not
// one.
std::optional<std::string_view> after_directive(std::string_view line, std::string_view directive);

// The lines of a text, without their ends.
std::vector<std::string_view> lines_of(std::string_view text);

// Sorted by path.
using SourceTree = std::vector<SourceFile>;

// Code, scripts, build files and papers; build folders and hidden ones are left out.
SourceTree read_source_tree(const std::filesystem::path& root);

}  // namespace checks
