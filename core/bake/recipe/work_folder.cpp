#include "bake/recipe/work_folder.h"

#include <system_error>
#include <vector>

#include "base/file.h"

namespace fb::bake {
namespace {

constexpr const char* part_prefix = "learning.";

}  // namespace

std::string part_folder_name(std::size_t poses) {
  return part_prefix + std::to_string(poses);
}

void tidy_work_folder(const std::filesystem::path& work) {
  std::vector<std::filesystem::path> done;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(work, missing)) {
    const std::string name = entry.path().filename().string();
    if (name == sampled_poses_name || name.starts_with(part_prefix) ||
        (name.starts_with(narrow_checkpoint) && entry.path().extension() == ".checkpoint"))
      done.push_back(entry.path());
  }
  for (const std::filesystem::path& path : done) remove_folder(path);
}

}  // namespace fb::bake
