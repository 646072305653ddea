#include "layer_law.h"

#include <filesystem>
#include <map>
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
    const bool writer = stem == "writer" || (stem.size() > 7 && stem.substr(stem.size() - 7) == "_writer") ||
                        path.find("/writer/") != std::string::npos;
    return writer ? "archive writer" : "archive reader";
  }
  if (begins(path, "core/bake/measure/")) return "bake/measure";
  if (begins(path, "capi/include/")) return "public headers";
  if (begins(path, "capi/bake/")) return "authoring C ABI";
  if (begins(path, "capi/")) return "C ABI";
  const std::size_t begin = begins(path, "core/") ? 5 : 0, end = path.find('/', begin);
  return end == std::string::npos ? "" : path.substr(begin, end - begin);
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

// What is between the quotes or brackets of an include; "" if the line includes nothing.
std::string included_by(std::string_view line) {
  const auto rest = after_directive(line, "include");
  if (!rest || rest->empty()) return "";
  const std::size_t end = rest->find(rest->front() == '<' ? '>' : '"', 1);
  return end == std::string_view::npos ? "" : std::string(rest->substr(1, end - 1));
}

}  // namespace

std::vector<std::string> layer_violations(const SourceTree& tree) {
  std::set<std::string> paths;
  for (const SourceFile& file : tree) paths.insert(file.path);

  std::vector<std::string> violations;
  for (const SourceFile& file : tree) {
    const std::string layer = layer_of(file.path);
    const auto allowed = law().find(layer);
    if (!file.is_code() || allowed == law().end()) continue;
    std::size_t number = 0;
    for (const std::string_view line : lines_of(file.text)) {
      ++number;
      const std::string include = included_by(line);
      if (include.empty()) continue;
      const std::string target = resolve(include, file.path, paths), target_layer = layer_of(target);
      const std::string where = file.path + ":" + std::to_string(number) + ": " + layer + " may not include ";
      if (layer == "model" && barred_from_model(include)) {
        violations.push_back(where + include);
      } else if (!target.empty() && target_layer != layer && !allowed->second.contains(target_layer)) {
        violations.push_back(where + target_layer + " (" + target + ")");
      }
    }
  }
  return violations;
}

}  // namespace checks
