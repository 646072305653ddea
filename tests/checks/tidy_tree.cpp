#include "tidy_tree.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>
#include <sstream>

namespace checks {

std::vector<std::string> stray_openmp(const SourceTree& tree) {
  const auto is_openmp = [](std::string_view line) {
    return after_directive(line, "pragma").value_or("").starts_with("omp ") ||
           line.find("_Pragma(\"omp ") != std::string_view::npos;
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    if (!file.is_code() || file.path == "core/base/parallel.cpp") continue;
    const auto lines = lines_of(file.text);
    if (std::any_of(lines.begin(), lines.end(), is_openmp))
      offences.push_back(file.path + ": an OpenMP pragma; use base/parallel.h");
  }
  return offences;
}

std::vector<std::string> repeated_names(const SourceTree& tree) {
  std::map<std::string, std::string> seen;
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    if (!file.is_code()) continue;
    const auto [first, fresh] = seen.emplace(file.name(), file.path);
    if (!fresh) offences.push_back(file.path + ": there is " + first->second + " already");
  }
  return offences;
}

std::vector<std::string> long_files(const SourceTree& tree) {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    const auto lines = lines_of(file.text).size();
    if (lines > 600) offences.push_back(file.path + ": " + std::to_string(lines) + " lines");
  }
  return offences;
}

std::vector<std::string> long_functions(const SourceTree& tree) {
  constexpr std::size_t most_lines = 60;
  const auto in_product = [](const std::string& path) {
    return path.starts_with("core/") || path.starts_with("capi/") || path.starts_with("packager/");
  };
  const auto begins_type_or_namespace = [](std::string_view line) {
    for (const std::string_view word :
         {"namespace", "class", "struct", "enum", "union", "extern", "constexpr", "const ", "typedef struct"})
      if (line.starts_with(word)) return true;
    return false;
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    if (!file.is_code() || !in_product(file.path)) continue;
    std::size_t number = 0, head = 0;  // head: the first line of the function, 0 outside of functions
    for (const std::string_view line : lines_of(file.text)) {
      ++number;
      const bool indented = line.empty() || line[0] == ' ' || line[0] == '#' || line[0] == '/';
      if (line.starts_with("}")) {
        if (head > 0 && number - head + 1 > most_lines)
          offences.push_back(file.path + ":" + std::to_string(head) + ": a function of " +
                             std::to_string(number - head + 1) + " lines");
        head = 0;
      } else if (!indented) {
        const bool opens = !line.ends_with(";") && !begins_type_or_namespace(line);
        head = opens ? number : 0;
      }
    }
  }
  return offences;
}

std::vector<std::string> typed_versions(const SourceTree& tree, const std::string& version) {
  const auto part_of_number = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) || c == '.'; };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    if (file.path == "CHANGELOG.md") continue;
    for (std::size_t at = file.text.find(version); at != std::string::npos; at = file.text.find(version, at + 1)) {
      const std::size_t end = at + version.size();
      const bool longer = (at > 0 && part_of_number(file.text[at - 1])) ||
                          (end < file.text.size() && std::isdigit(static_cast<unsigned char>(file.text[end])));
      if (!longer) offences.push_back(file.path + ": types the version, which only VERSION does");
    }
  }
  return offences;
}

std::vector<std::string> pinned_packages(const SourceTree& tree) {
  constexpr std::string_view call = "find_package(";
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    if (file.name() != "CMakeLists.txt" && file.extension() != ".cmake") continue;
    for (std::size_t at = file.text.find(call); at != std::string::npos; at = file.text.find(call, at + 1)) {
      const std::size_t first = at + call.size();
      std::istringstream words(file.text.substr(first, file.text.find(')', first) - first));
      for (std::string word; words >> word;)
        if (std::isdigit(static_cast<unsigned char>(word[0])))
          offences.push_back(file.path + ": find_package in version " + word + "; name none");
    }
  }
  return offences;
}

std::vector<std::string> ranges_in_runtime(const SourceTree& tree) {
  const auto in_runtime = [](const std::string& path) {
    for (const std::string_view layer : {"core/base/", "core/model/", "core/archive/", "core/runtime/"})
      if (path.starts_with(layer)) return path != "core/base/csv_file.cpp";  // which only baking reads
    return false;
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree)
    if (in_runtime(file.path) && file.is_code() && file.text.find("std::ranges::") != std::string::npos)
      offences.push_back(file.path + ": std::ranges, which the C++ library of Debian 12's Emscripten lacks");
  return offences;
}

std::vector<std::string> shared_streams(const SourceTree& tree) {
  static const std::regex use("\\bStream::(\\w+)"), unnamed("\\bRandom( \\w+)?[({]");
  std::map<std::string, std::string> seen;
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    const bool in_product =
        file.path.starts_with("core/") || file.path.starts_with("capi/") || file.path.starts_with("packager/");
    if (!in_product || !file.is_code() || file.path.starts_with("core/base/random")) continue;
    if (std::regex_search(file.text, unnamed))
      offences.push_back(file.path + ": random numbers of no use of the seed; open_stream makes them");
    for (std::sregex_iterator found(file.text.begin(), file.text.end(), use), end; found != end; ++found) {
      const auto [first, fresh] = seen.emplace((*found)[1], file.path);
      if (!fresh) offences.push_back(file.path + ": Stream::" + first->first + " is drawn from in " + first->second);
    }
  }
  return offences;
}

}  // namespace checks
