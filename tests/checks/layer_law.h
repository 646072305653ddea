// Which part of the tree may include which.
#pragma once

#include <string>
#include <vector>

#include "source_tree.h"

namespace checks {

// One line for each include that the layers forbid: "core/model/mesh.h:7: model may not include bake/rig (...)".
//
//     base <- model <- archive reader <- runtime <- C ABI <- bindings, samples (public headers only)
//     base, model, archive writer <- bake <- authoring C ABI <- packager
//
// Within core/bake every folder is a layer of its own; bake/measure alone includes runtime. model has neither I/O nor
// threads. Only tests include tests.
std::vector<std::string> layer_violations(const SourceTree& tree);

// One line for each circle of folders that include each other: "core/a -> core/b -> core/a".
std::vector<std::string> folder_circles(const SourceTree& tree);

// One line for each file whose namespace is not that of its folder: fb::archive, fb::runtime, fb::bake, fb::capi and
// fb::tool (packager); base and model are the namespace fb itself.
std::vector<std::string> stray_namespaces(const SourceTree& tree);

}  // namespace checks
