#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_options.h"
#include "bake/rig/source.h"
#include "base/progress.h"

namespace fb::bake {

// How live rigs are run.
struct RigRunning {
  std::size_t workers = 0;         // child processes at once; 0: this process, and one child of a command
  std::string host = "facebaker";  // the program that serves a rig in a child (`HOST rig-host SOURCE`)
  double pose_seconds = 60;        // see RigCommand
  Progress* progress = nullptr;    // asked while children start; null: nobody is
  GltfOptions gltf = {};           // how glTF files are read
};

// Opens what the command line calls SOURCE: a dataset folder, a rig plugin (.so), a .glb, .gltf or .vrm with
// morph targets or joints, "exec:COMMAND" for a child process that speaks the rig protocol, or "sample" for the
// built-in face. Fails with io, naming the holder of its lock, for a folder that is being sampled: it may lack poses
// without lacking a file.
OpenedSource open_source(const std::string& source, const RigRunning& running = {});

// Several datasets of one character as one source; fails unless controls and rest meshes agree. Needs at least one.
// Fails where running.gltf says something and no source is a glTF file.
OpenedSource open_sources(const std::vector<std::string>& sources, const RigRunning& running = {});

}  // namespace fb::bake
