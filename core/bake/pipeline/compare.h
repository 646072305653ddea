#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/recipe/bake_options.h"
#include "bake/rig/source.h"
#include "base/progress.h"
#include "figures/face_figures.h"

namespace fb::bake {

struct CompareReport : FaceFigures {
  // The dataset sampled from a live rig, with the clips measured on; null where they are the source's own.
  std::unique_ptr<Source> recorded;
};

// Bakes every method on the same poses and measures the packed archives on the same clips. A live rig is sampled once;
// one without test clips is tested on held-out random poses and synthetic shots. Fails with bad_data on a recording
// without a test split. A method that fails is noted and the others are compared; its error is thrown if all fail.
// Archives stay in the work folder and are not baked again (cached_bake); they are always measured.
CompareReport compare(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                      Progress& progress);

}  // namespace fb::bake
