#include "source_tree.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

namespace checks {

bool SourceFile::is_code() const {
  static const std::set<std::string> extensions = {".c", ".cpp", ".h", ".hpp", ".inl"};
  return extensions.contains(extension());
}

SourceTree read_source_tree(const std::filesystem::path& root) {
  static const std::set<std::string> extensions = {".c",    ".cpp", ".h",   ".hpp",   ".inl",  ".py", ".sh", ".md",
                                                   ".json", ".txt", ".map", ".cmake", ".toml", ".in", ".cs", ".js"};
  static const std::set<std::string> skipped = {"build", "install", "__pycache__"};
  SourceTree tree;
  for (auto it = std::filesystem::recursive_directory_iterator(root); it != decltype(it)(); ++it) {
    const std::string name = it->path().filename().string();
    if (it->is_directory()) {
      if (name[0] == '.' || skipped.contains(name)) it.disable_recursion_pending();
    } else if (extensions.contains(it->path().extension().string())) {
      std::ifstream stream(it->path(), std::ios::binary);
      tree.push_back({it->path().lexically_relative(root).generic_string(),
                      std::string(std::istreambuf_iterator<char>(stream), {})});
    }
  }
  std::sort(tree.begin(), tree.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return tree;
}

}  // namespace checks
