#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace fb::bake {

// State saved so that an interrupted bake resumes where it stopped.
struct Checkpoint {
  std::uint64_t key = 0;   // a hash of the data and options that the state belongs to
  std::uint64_t step = 0;  // the step to resume at
  std::vector<std::vector<float>> arrays;
};

// Writes a temporary file and renames it.
void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);
// Nothing if the file is missing or damaged, or has another key.
std::optional<Checkpoint> load_checkpoint(const std::filesystem::path& path, std::uint64_t key);

}  // namespace fb::bake
