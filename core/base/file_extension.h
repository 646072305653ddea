#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace fb {

// A text with the letters A to Z in lower case.
std::string lower_case(std::string_view text);

// The extension of a file's name, with its point and in lower case, by which kinds of files are told apart: ".glb" of
// "Face.GLB"; "" where it has none.
std::string file_extension(const std::filesystem::path& path);

}  // namespace fb
