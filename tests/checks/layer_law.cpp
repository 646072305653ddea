#include "layer_law.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

namespace checks {
namespace {

using Layers = std::set<std::string>;

bool begins(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

// The layer that a file belongs to; "" for what the law does not speak of.
std::string layer_of(const std::string& path) {
  const std::string name = path.substr(path.rfind('/') + 1);
  const std::string stem = name.substr(0, name.rfind('.'));
  if (begins(path, "core/archive/")) {
    const bool writer = stem == "writer" || (stem.size() > 7 && stem.substr(stem.size() - 7) == "_writer");
    return writer ? "archive writer" : "archive reader";
  }
  if (begins(path, "core/bake/measure/")) return "bake/measure";
  if (begins(path, "capi/include/")) return "public headers";
  if (begins(path, "capi/")) return stem.find("bake") != std::string::npos ? "authoring C ABI" : "C ABI";
  static const std::regex folder("(?:core/)?([a-z_]+)/.*");
  std::smatch match;
  return std::regex_match(path, match, folder) ? match[1].str() : "";
}

// What each layer may include besides itself.
const std::map<std::string, Layers>& law() {
  static const std::map<std::string, Layers> law = [] {
    std::map<std::string, Layers> may;
    may["base"] = {};
    may["model"] = {"base"};
    may["archive reader"] = {"base", "model"};
    may["archive writer"] = {"base", "model", "archive reader"};
    may["runtime"] = {"base", "model", "archive reader"};
    may["bake"] = {"base", "model", "archive reader", "archive writer", "bake/measure", "public headers"};
    may["bake/measure"] = {"base", "model", "archive reader", "archive writer", "bake", "runtime", "public headers"};
    may["public headers"] = {};
    may["C ABI"] = {"base", "model", "archive reader", "runtime", "public headers"};
    may["authoring C ABI"] = may["C ABI"];
    may["authoring C ABI"].insert({"C ABI", "archive writer", "bake", "bake/measure"});
    may["packager"] = may["authoring C ABI"];
    may["bindings"] = {"public headers"};
    may["samples"] = {"public headers"};
    return may;
  }();
  return law;
}

// Folders that an include may be written from, besides the including file's own.
const std::vector<std::string> roots = {"core/",     "capi/",     "capi/include/",
                                        "packager/", "bindings/", "bindings/python/",
                                        "samples/",  "tests/",    "tests/rigs/"};

// The file of the tree that an include means; "" for the system's and libraries' own.
std::string resolve(const std::string& include, const std::string& from, const std::set<std::string>& paths) {
  std::vector<std::string> folders = roots;
  folders.insert(folders.begin(), from.substr(0, from.rfind('/') + 1));
  for (const std::string& folder : folders) {
    const std::string path = std::filesystem::path(folder + include).lexically_normal().generic_string();
    if (paths.contains(path)) return path;
  }
  return "";
}

// model may not reach for the system or for threads through the standard library either.
bool barred_from_model(const std::string& include) {
  static const std::set<std::string> barred = {"base/file.h", "base/parallel.h", "atomic",   "cstdio", "filesystem",
                                               "fstream",     "future",          "iostream", "mutex",  "thread"};
  return barred.contains(include);
}

}  // namespace

std::vector<std::string> layer_violations(const SourceTree& tree) {
  std::set<std::string> paths;
  for (const SourceFile& file : tree) paths.insert(file.path);

  std::vector<std::string> violations;
  static const std::regex include("[ \t]*#[ \t]*include[ \t]*[<\"]([^>\"]+)[>\"]");
  for (const SourceFile& file : tree) {
    const std::string layer = layer_of(file.path);
    const auto allowed = law().find(layer);
    if (!file.is_code() || allowed == law().end()) continue;
    std::size_t line = 1;
    for (std::size_t begin = 0; begin < file.text.size(); ++line) {
      const std::size_t end = std::min(file.text.find('\n', begin), file.text.size());
      const auto first = file.text.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = file.text.begin() + static_cast<std::ptrdiff_t>(end);
      begin = end + 1;
      std::smatch match;
      if (!std::regex_search(first, last, match, include, std::regex_constants::match_continuous)) continue;
      const std::string target = resolve(match[1], file.path, paths);
      const std::string where = file.path + ":" + std::to_string(line) + ": " + layer + " may not include ";
      if (layer == "model" && barred_from_model(match[1])) {
        violations.push_back(where + match[1].str());
      } else if (!target.empty() && layer_of(target) != layer && !allowed->second.contains(layer_of(target))) {
        violations.push_back(where + layer_of(target) + " (" + target + ")");
      }
    }
  }
  return violations;
}

}  // namespace checks
