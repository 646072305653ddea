#include "layer_law.h"

#include <algorithm>
#include <filesystem>
#include <functional>
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
  if (begins(path, "core/bake/")) {
    const std::size_t end = path.find('/', 10);
    return end == std::string::npos ? "bake" : path.substr(5, end - 5);
  }
  if (begins(path, "capi/include/")) return "public headers";
  if (begins(path, "capi/bake/")) return "authoring C ABI";
  if (begins(path, "capi/")) return "C ABI";
  const std::size_t begin = begins(path, "core/") ? 5 : 0, end = path.find('/', begin);
  return end == std::string::npos ? "" : path.substr(begin, end - begin);
}

// What each layer may include besides itself.
const std::map<std::string, Layers>& law() {
  static const std::map<std::string, Layers> law = [] {
    const Layers nouns = {"base", "model"};
    const auto with = [](Layers layers, const Layers& more) {
      layers.insert(more.begin(), more.end());
      return layers;
    };
    std::map<std::string, Layers> may;
    may["base"] = {};
    may["model"] = {"base"};
    may["figures"] = {"base"};
    may["archive reader"] = nouns;
    may["archive writer"] = with(nouns, {"archive reader"});
    may["runtime"] = with(nouns, {"archive reader"});

    // Folders of core/bake, each with those it is built on.
    const Layers written = with(nouns, {"archive reader", "archive writer"});
    const Layers data = {"bake/rig", "bake/dataset"};
    may["bake/linalg"] = nouns;
    may["bake/rights"] = nouns;
    may["bake/rig"] = with(nouns, {"public headers", "bake/rights"});
    may["bake/rig_process"] = with(nouns, {"bake/rig"});
    may["bake/dataset"] = with(may["bake/rig"], {"bake/rig", "bake/rig_process"});
    may["bake/analysis"] = with(nouns, {"bake/linalg", "bake/rig"});
    may["bake/sampling"] = with(with(nouns, data), {"bake/analysis"});
    may["bake/check"] = with(with(nouns, data), {"figures", "bake/sampling"});
    may["bake/regions"] = with(nouns, {"bake/linalg", "bake/rig", "bake/analysis"});
    may["bake/train"] = with(nouns, {"bake/linalg", "figures"});
    may["bake/compress"] = with(written, {"bake/linalg"});
    may["bake/measure"] = with(written, {"figures", "runtime", "bake/rig", "bake/regions"});
    may["bake/bag"] = with(nouns, {"archive reader", "bake/rig", "bake/measure"});
    may["bake/recipe"] = with(nouns, {"figures", "bake/rig", "bake/compress", "bake/train"});
    may["bake/levels"] = with(with(nouns, data), {"bake/regions", "bake/recipe"});
    may["bake/face"] =
        with(with(written, data), {"figures", "bake/linalg", "bake/analysis", "bake/sampling", "bake/regions",
                                   "bake/train", "bake/compress", "bake/measure", "bake/recipe"});
    may["bake/baselines"] = with(may["bake/face"], {"bake/face"});
    may["bake/export"] = nouns;
    may["bake/signing"] = with(nouns, {"bake/rig"});
    may["bake/pipeline"] =
        with(may["bake/baselines"], {"bake/baselines", "bake/levels", "bake/rights", "bake/signing"});

    may["public headers"] = {};
    may["C ABI"] = with(nouns, {"archive reader", "runtime", "public headers"});
    may["authoring C ABI"] =
        with(with(may["C ABI"], may["bake/pipeline"]), {"C ABI", "bake/pipeline", "bake/rig_process", "bake/check",
                                                        "bake/export", "bake/rights", "bake/bag", "bake/signing"});
    may["packager"] = {"base", "figures", "public headers"};
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

namespace {

// An include of one file of the tree by another.
struct Include {
  const SourceFile* file;
  std::size_t line;
  std::string text, target;  // target: "" if it is none of the tree
};

std::vector<Include> includes_of(const SourceTree& tree) {
  std::set<std::string> paths;
  for (const SourceFile& file : tree) paths.insert(file.path);
  std::vector<Include> includes;
  for (const SourceFile& file : tree) {
    if (!file.is_code()) continue;
    std::size_t number = 0;
    for (const std::string_view line : lines_of(file.text)) {
      ++number;
      const std::string text = included_by(line);
      if (!text.empty()) includes.push_back({&file, number, text, resolve(text, file.path, paths)});
    }
  }
  return includes;
}

std::string folder_of(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

bool is_product(const std::string& path) {
  return begins(path, "core/") || begins(path, "capi/") || begins(path, "packager/");
}

// The namespace that belongs to a folder; "" where any will do.
std::string namespace_of(const std::string& path) {
  for (const char* layer : {"archive", "runtime", "bake"})
    if (begins(path, std::string("core/") + layer + "/")) return std::string("fb::") + layer;
  if (begins(path, "core/")) return "fb";
  if (begins(path, "capi/include/")) return "";
  if (begins(path, "capi/")) return "fb::capi";
  if (begins(path, "packager/")) return "fb::tool";
  return "";
}

}  // namespace

std::vector<std::string> layer_violations(const SourceTree& tree) {
  std::vector<std::string> violations;
  for (const Include& include : includes_of(tree)) {
    const std::string layer = layer_of(include.file->path), target_layer = layer_of(include.target);
    const auto allowed = law().find(layer);
    if (allowed == law().end()) continue;
    const std::string where =
        include.file->path + ":" + std::to_string(include.line) + ": " + layer + " may not include ";
    if (layer == "model" && barred_from_model(include.text)) {
      violations.push_back(where + include.text);
    } else if (!include.target.empty() && target_layer != layer && !allowed->second.contains(target_layer)) {
      violations.push_back(where + target_layer + " (" + include.target + ")");
    }
  }
  return violations;
}

std::vector<std::string> folder_circles(const SourceTree& tree) {
  std::map<std::string, std::set<std::string>> edges;
  for (const Include& include : includes_of(tree)) {
    if (!is_product(include.file->path) || !is_product(include.target)) continue;
    const std::string from = folder_of(include.file->path), to = folder_of(include.target);
    if (from != to) edges[from].insert(to);
  }
  std::vector<std::string> circles;
  std::set<std::string> done;
  std::vector<std::string> trail;
  const std::function<void(const std::string&)> visit = [&](const std::string& folder) {
    const auto seen = std::find(trail.begin(), trail.end(), folder);
    if (seen != trail.end()) {
      std::string circle;
      for (auto at = seen; at != trail.end(); ++at) circle += *at + " -> ";
      circles.push_back(circle + folder);
      return;
    }
    if (done.contains(folder)) return;
    trail.push_back(folder);
    for (const std::string& next : edges[folder]) visit(next);
    trail.pop_back();
    done.insert(folder);
  };
  std::vector<std::string> folders;
  for (const auto& [folder, targets] : edges) folders.push_back(folder);
  for (const std::string& folder : folders) visit(folder);
  return circles;
}

std::vector<std::string> stray_namespaces(const SourceTree& tree) {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree) {
    const std::string wanted = namespace_of(file.path);
    if (!file.is_code() || wanted.empty()) continue;
    std::size_t number = 0;
    for (const std::string_view line : lines_of(file.text)) {
      ++number;
      if (!line.starts_with("namespace fb")) continue;
      const std::string_view rest = line.substr(10);
      const std::string name(rest.substr(0, rest.find(' ')));
      const bool same = wanted == "fb" ? name == "fb" : name == wanted || begins(name, wanted + "::");
      if (!same)
        offences.push_back(file.path + ":" + std::to_string(number) + ": namespace " + name + ", not " + wanted);
    }
  }
  return offences;
}

}  // namespace checks
