// The page that people look at to judge a face: figures, curves and pictures of the rig and of what was made of it.
#pragma once

#include <filesystem>
#include <string>

#include "bake/pipeline/compare.h"

namespace fb::tool {
using namespace bake;

// Fails with io unless the folder is missing, empty or a report; then makes it one, so that whoever finds
// it unfinished knows what it is.
void claim_report_folder(const std::filesystem::path& folder);

// A report of one face.
CompareReport alone(MethodReport face, const Source& source);

struct FaceReport {
  std::string title;
  std::string measured_on;  // a sentence that says which clips the errors are of
  const CompareReport& faces;
  Source& frames;  // has the clips that were measured on
};

// Writes folder/index.html and the pictures it shows, each file whole or not at all, the page last. The folder is one
// that claim_report_folder made.
void write_face_report(const std::filesystem::path& folder, const FaceReport& report, const Parallel& parallel,
                       Progress& progress);

}  // namespace fb::tool
