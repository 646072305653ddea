#pragma once

#include <filesystem>
#include <string>

namespace fb::bake {

// How a face is baked of a file that is no source by itself, by its suffix, in a sentence; "" of other files. The table
// of README.md, "Sources", says the same.
std::string way_to_bake(const std::filesystem::path& file);

}  // namespace fb::bake
