// Whether a bag is valid and whole, and its faces pose as archived.
#pragma once

#include <filesystem>

#include "bake/bag/bag_report.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Reads a BagIt bag (RFC 8493), which may come from anyone, and finds all that is wrong with it: its structure and
// texts, every file that is missing, changed or listed nowhere, and archives that do not evaluate as archived
// (verify_archive). No link is followed and nothing outside the folder is read. Files are read in pieces, but for
// archives, each of which is in memory while it is evaluated. Fails with not_found and io where there is no folder to
// read, with limit on more than a million files, and with interrupted.
BagReport check_bag(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
