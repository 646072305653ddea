// Which part of the tree may include which.
#pragma once

#include <string>
#include <vector>

#include "source_tree.h"

namespace checks {

// One line for each include that the law of layers forbids: "core/model/mesh.h:7: model may not include bake (...)".
//
//     base <- model <- archive (reader) <- runtime <- C ABI <- bindings, samples (which see the public headers alone)
//     base, model, archive (writer) <- bake <- authoring C ABI <- packager
//
// Of bake only bake/measure may include runtime. model has neither I/O nor threads. Nothing but tests includes tests.
std::vector<std::string> layer_violations(const SourceTree& tree);

}  // namespace checks
