// Dataset folders whose controls are known before their points: those that are being sampled, and plans for programs to
// evaluate.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "bake/dataset/dataset_index.h"
#include "bake/sampling/sampling.h"

namespace fb::bake {

// dataset.json of a plan: names of files made from those of clips, points in shards of so many frames; 0: one file a
// clip.
DatasetIndex index_of_plan(const Source& rig, const PosePlan& plan, std::size_t shard_frames);

// Writes what such an index names besides points and channels: rest mesh (unless the rig has none), images, skin and
// controls. Files that are there and look right stay.
void write_planned_files(const Source& rig, const PosePlan& plan, const DatasetIndex& index,
                         const std::filesystem::path& folder);

// The plan that lies in a folder.
PosePlan read_plan(const std::filesystem::path& folder, const DatasetIndex& index);

// True if the file is a NumPy array of this shape.
bool is_array(const std::filesystem::path& path, const std::vector<std::size_t>& shape);

// The poses that some program should evaluate: of a live rig, those that `sample` evaluates; of anything else, those
// that follow from its controls alone, as if all of them moved alike, within a rig budget of all poses, so that every
// control is seen alone at the ends of its range (unless there are too few poses for that). The rest pose comes first,
// as the clip "rest_pose", so that whoever checks the points sees whether they fit the rest mesh. Options that are
// about the evaluation have no effect. Fails as sample does.
PosePlan plan_poses(Source& source, const SamplingOptions& options, const Parallel& parallel, Progress& progress);

// Writes a plan as a dataset folder without points, whose index says that it is a plan: a program that writes the files
// of points which it names completes it, clip by clip. A folder that holds the same plan stays as it is; one that holds
// another dataset is refused with invalid_argument. Locks the folder meanwhile.
void write_plan_folder(const Source& rig, const PosePlan& plan, const std::filesystem::path& folder);

}  // namespace fb::bake
