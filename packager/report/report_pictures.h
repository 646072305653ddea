#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "report/frame_pictures.h"
#include "report/report_view.h"

namespace fb::tool {

// The pictures of a report: worst frames, error maps, Figures 1 and 3 of the paper. Reads the frames when it is made,
// so that one camera and one scale of colours serve all, and writes pictures into the report's folder as they are added
// to the page. Adds nothing where nothing was measured. view, source and progress must outlive it.
class ReportPictures {
 public:
  ReportPictures(const ReportView& view, const facebaker::SourceView& source, const std::filesystem::path& folder,
                 const Parallel& parallel, Progress& progress);

  // The frame with the worst vertex of all.
  void add_worst(Html& page) const;
  // Regions and controls, the other worst frames, errors over the face, posed faces; folded.
  void add_sections(Html& page) const;

 private:
  const ReportView& view_;
  Progress& progress_;
  std::vector<PosedFrame> figure_1_, expressive_, worst_, contact_;
  std::optional<FramePictures> pictures_;
};

}  // namespace fb::tool
