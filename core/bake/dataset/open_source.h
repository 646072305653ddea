#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Opens what the command line calls SOURCE: a dataset folder, a rig plugin (.so), a .glb or .gltf with
// morph targets, or "sample" for the built-in face. Fails with io, naming the holder of its lock, for a folder that is
// being sampled: it may lack poses without lacking a file.
OpenedSource open_source(const std::string& source);

// Several datasets of one character as one source; fails unless controls and rest meshes agree. Needs at least one.
OpenedSource open_sources(const std::vector<std::string>& sources);

}  // namespace fb::bake
