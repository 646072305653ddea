// The page by which people judge a face: figures, curves and pictures of the rig and of the baked faces.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "base/output_lock.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "report/figures.h"

namespace fb::tool {

// Makes a folder for a report, with a page that says that work is going on, and locks it. Fails with io unless the
// folder is missing, empty or a report already.
[[nodiscard]] OutputLock claim_report_folder(const std::filesystem::path& folder);

struct FaceReport {
  std::string title;
  std::string measured_on;  // a sentence: the clips that the errors are of
  const FaceFigures& figures;
  facebaker::SourceView source;  // has the clips that were measured on
  // Lines of a shell that show the face in the viewer; none: the page does not speak of it.
  std::vector<std::string> view_lines = {};
};

// "Measured on the clips of the split test.", or why nothing was measured.
std::string measured_on(const FaceFigures& figures);

// Writes folder/index.html and its pictures, each file complete or not at all, the page last, into a folder of
// claim_report_folder.
void write_face_report(const std::filesystem::path& folder, const FaceReport& report, const Parallel& parallel,
                       Progress& progress);

}  // namespace fb::tool
