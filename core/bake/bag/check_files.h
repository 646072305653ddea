// The bytes of a bag's files.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bake/bag/bag_report.h"
#include "bake/bag/closed_folder.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

inline constexpr const char* archives_prefix = "data/archives/";  // of bags that we write

struct ExpectedDigest {
  std::string algorithm, digest, manifest;
};

// Compares checksums of these files, and evaluates the proof of those that are FaceBaker archives: by their signature,
// and all that are called .fbk in data/archives/. Adds faults, in the order of paths, and archives.
void check_files(const ClosedFolder& folder, const std::map<std::string, std::vector<ExpectedDigest>>& files,
                 const Parallel& parallel, Progress& progress, BagReport& report);

}  // namespace fb::bake
