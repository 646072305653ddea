// What is wrong with a dataset folder, all of it, and how well its poses cover a face.
#pragma once

#include <filesystem>

#include "base/parallel.h"
#include "base/progress.h"
#include "figures/dataset_figures.h"

namespace fb::bake {

// Fails only where there is no folder, or with interrupted. Reads all of it, points in blocks.
DatasetFigures check_dataset(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
