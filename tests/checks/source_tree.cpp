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

std::optional<std::string_view> after_directive(std::string_view line, std::string_view directive) {
  const auto skip_blanks = [&] { line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size())); };
  const auto skip = [&](std::string_view word) {
    skip_blanks();
    if (!line.starts_with(word)) return false;
    line.remove_prefix(word.size());
    return true;
  };
  if (!skip("#") || !skip(directive)) return std::nullopt;
  skip_blanks();
  return line;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
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
