// The page about a dataset folder: what is wrong with it, what its points look like, what its poses cover.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <optional>

#include "base/parallel.h"
#include "base/progress.h"
#include "report/dataset_text.h"

namespace fb::tool {

// Writes folder/index.html and its pictures, the page last, into a folder of claim_report_folder. `source`: the
// dataset, for pictures of its points; none where it cannot be opened.
void write_dataset_report(const std::filesystem::path& folder, const DatasetFigures& figures,
                          const std::optional<facebaker::SourceView>& source, const Parallel& parallel,
                          Progress& progress);

}  // namespace fb::tool
