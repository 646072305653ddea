#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace fb::bake {

// Numbers put by so that an interrupted bake goes on where it stopped.
struct Checkpoint {
  std::uint64_t key = 0;   // what they belong to: a hash of data and options
  std::uint64_t step = 0;  // how far the work was
  std::vector<std::vector<float>> arrays;
};

// Written to a temporary file and renamed.
void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);
// Nothing if there is no such file, it is damaged, or it belongs to other work.
std::optional<Checkpoint> load_checkpoint(const std::filesystem::path& path, std::uint64_t key);

}  // namespace fb::bake
