// What shows a face where nobody reads .fbk: a picture, a model, and how far the model is off.
#pragma once

#include <string>

#include "base/parallel.h"

namespace fb::tool {

// Writes base + ".png", the rest pose in its colours, base + ".glb", with the blendshapes of the controls that move the
// face most, and base + ".txt", which says what they are and by how much the blendshapes are off.
void write_access_copies(const std::string& archive, const std::string& base, const Parallel& parallel);

}  // namespace fb::tool
