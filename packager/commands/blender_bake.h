#pragma once

#include <string>

namespace fb::tool {

// Has Blender bake `source`, a scene of its own or a file that it imports, by the add-on: takes the place of this
// process, with the other words of its command line. Fails, naming what is missing, if there is no Blender in PATH or
// no add-on beside this program.
[[noreturn]] void bake_with_blender(const std::string& source);

}  // namespace fb::tool
