// What lies in the work folder of a bake, beside the checkpoints that recipes name themselves.
#pragma once

#include <filesystem>
#include <string>

namespace fb::bake {

// Evaluations of a slow rig, shared by all stages of a bake or comparison.
inline constexpr const char* evaluations_name = "rig.evaluations";
// Poses sampled of a live rig, a dataset.
inline constexpr const char* sampled_poses_name = "poses";

// The folder of a bake on part of the poses, for the learning curve.
std::string part_folder_name(std::size_t poses);

// Checkpoints of the narrow networks that tell how large the regions' own shall be; those of the latter are kept
// longer.
inline constexpr const char* narrow_checkpoint = "first";

// Gives back what is done, once an archive is complete: sampled poses, bakes on part of the poses, narrow networks.
// What a rig answered stays, for BakeOptions::reuse, and so do the checkpoints of what was trained: the same bake with
// other exact poses does not train again.
void tidy_work_folder(const std::filesystem::path& work);

}  // namespace fb::bake
