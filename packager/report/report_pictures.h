#pragma once

#include "report/report_view.h"

namespace fb::tool {

// The sections of pictures, written into `folder` as they are made: the paper's Figures 1 and 3, where errors are over
// the face, and the worst frames.
void add_pictures(Html& page, const ReportView& view, Source& frames, const std::filesystem::path& folder,
                  const Parallel& parallel, Progress& progress);

}  // namespace fb::tool
