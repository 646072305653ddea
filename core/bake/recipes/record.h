#pragma once

#include <memory>

#include "bake/recipes/bake.h"

namespace fb {

enum class Recording {
  training_only,
  with_test,  // the rig's test clips too, or held-out random poses and synthetic shots where it has none
};

// Samples a live rig into a dataset in the work folder, or finds it there, and opens it.
std::unique_ptr<Source> record(Source& rig, const BakeOptions& options, Recording what, Progress& progress);

}  // namespace fb
