#include "bake/dataset/open_source.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "bake/dataset/dataset_index.h"
#include "bake/dataset/dataset_source.h"
#include "bake/dataset/merged_source.h"
#include "bake/dataset/other_files.h"
#include "bake/rig/gltf/gltf_rig.h"
#include "bake/rig/rig_source.h"
#include "bake/rig/source.h"
#include "bake/rig_process/process_source.h"
#include "base/file.h"
#include "base/file_extension.h"
#include "base/hash.h"
#include "base/match_names.h"
#include "base/output_lock.h"
#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

// Where the built-in face may lie, most specific first: folders named by FACEBAKER_RIG_PATH, beside the program (in a
// build, or installed under any prefix), beside the library this code is part of, and where `install` puts it.
std::vector<fs::path> rig_folders() {
  std::vector<fs::path> folders;
  if (const char* list = std::getenv("FACEBAKER_RIG_PATH")) {
    std::istringstream stream(list);
    stream.exceptions(std::ios::badbit);
    for (std::string folder; std::getline(stream, folder, ':');)
      if (!folder.empty()) folders.emplace_back(folder);
  }
  std::error_code error;
  if (const fs::path program = fs::read_symlink("/proc/self/exe", error); !error) {
    const fs::path prefix = program.parent_path().parent_path();
    folders.push_back(prefix / "lib" / "rigs");
    folders.push_back(prefix / FB_INSTALL_LIBDIR / "facebaker" / "rigs");
  }
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&open_source), &info) && info.dli_fname) {
    const fs::path here = fs::absolute(info.dli_fname).parent_path();
    folders.push_back(here / "rigs");
    folders.push_back(here / "facebaker" / "rigs");
  }
  folders.emplace_back(FB_INSTALL_RIG_DIR);
  return folders;
}

// The plugin of the built-in face; "" where it is missing.
std::string sample_file() {
  for (const fs::path& folder : rig_folders())
    if (const fs::path file = folder / "librig_sample.so"; fs::is_regular_file(file)) return file.string();
  return "";
}

OpenedSource open_sample() {
  const std::string file = sample_file();
  if (!file.empty()) return open_rig_plugin(file);
  std::string looked;
  for (const fs::path& folder : rig_folders()) looked += "\n  " + shown(folder);
  fail(Status::not_found, "the sample face (librig_sample.so) is in none of%s", looked.c_str());
}

// A rig in children: a command, or what `host` serves.
OpenedSource open_in_children(const std::string& source, std::vector<std::string> arguments, const RigRunning& running,
                              std::uint64_t program_hash) {
  RigCommand command{source, std::move(arguments), std::max<std::size_t>(running.workers, 1), running.pose_seconds,
                     program_hash};
  return std::make_unique<ProcessSource>(std::move(command), running.progress);
}

bool is_gltf(const std::string& source) {
  const std::string extension = file_extension(source);
  return !source.starts_with(command_prefix) && (extension == ".glb" || extension == ".gltf" || extension == ".vrm");
}

// What serves a rig in a child. The words of its options are those of the command rig-host.
std::vector<std::string> host_arguments(const std::string& source, const RigRunning& running) {
  std::vector<std::string> arguments = {running.host, "rig-host", source};
  if (!is_gltf(source)) return arguments;
  if (running.gltf.joints != JointUse::automatic)
    arguments.emplace_back(running.gltf.joints == JointUse::controls ? "--joints=controls" : "--joints=ignore");
  for (const std::string& name : running.gltf.control_joints) arguments.push_back("--control-joint=" + name);
  if (running.gltf.skip_broken) arguments.emplace_back("--skip-broken");
  return arguments;
}

}  // namespace

OpenedSource open_source(const std::string& source, const RigRunning& running) {
  if (source.starts_with(command_prefix))
    return open_in_children(source, {"/bin/sh", "-c", source.substr(std::string_view(command_prefix).size())}, running,
                            hash64_of(std::span<const char>(source)));
  if (running.workers > 0 && !fs::is_directory(source)) {
    const std::string file = source == "sample" ? sample_file() : source;
    const std::uint64_t hash = fs::is_regular_file(file) ? hash64(read_file(file)) : 0;
    return open_in_children(source, host_arguments(source, running), running, hash);
  }
  if (source == "sample") return open_sample();
  const fs::path path(source);
  if (!fs::exists(path)) {
    const bool mistyped = nearest_name(source, {"sample"}).has_value();
    fail(Status::not_found, "%s: no such file or folder%s", shown(source).c_str(),
         mistyped ? "; did you mean the built-in rig, named \"sample\"?" : "");
  }
  if (fs::is_directory(path)) {
    OutputLock::refuse_if_written(path);
    if (!fs::exists(path / dataset_file))
      fail(Status::not_found, "%s: is no dataset folder: it holds no %s", shown(source).c_str(), dataset_file);
    return std::make_unique<DatasetSource>(path);
  }
  if (is_gltf(source)) return open_gltf_rig(source, running.gltf);
  if (file_extension(path) == ".so") return open_rig_plugin(source);
  if (const std::string way = way_to_bake(path); !way.empty())
    fail(Status::invalid_argument, "%s: no source by itself, but %s", shown(source).c_str(), way.c_str());
  fail(Status::invalid_argument,
       "%s: neither a dataset folder, a rig plugin (.so), a glTF file (.glb, .gltf, .vrm) nor a command (exec:COMMAND)",
       shown(source).c_str());
}

OpenedSource open_sources(const std::vector<std::string>& sources, const RigRunning& running) {
  if (sources.empty()) fail(Status::invalid_argument, "no source is given");
  if (running.gltf != GltfOptions{} && std::ranges::none_of(sources, is_gltf))
    fail(Status::invalid_argument,
         "joints are chosen as controls or ignored, or broken parts left out, but no source is a glTF file");
  if (sources.size() == 1) return open_source(sources[0], running);
  std::vector<std::unique_ptr<Source>> opened;
  for (const std::string& source : sources) opened.push_back(open_source(source, running));
  return std::make_unique<MergedSource>(std::move(opened), sources);
}

}  // namespace fb::bake
