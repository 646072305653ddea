#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace fb::tool {

// A character to bake.
struct FarmCharacter {
  std::string name;                // of its files; unique
  std::size_t line;                // of the list, from 1
  std::vector<std::string> words;  // sources and options of `bake`
};

// Reads a list: a character a line, [NAME=]SOURCE [OPTIONS], see docs/many-machines.md. Fails with bad_data, naming the
// line, and as read_file does.
std::vector<FarmCharacter> read_character_list(const std::filesystem::path& path);

}  // namespace fb::tool
