#pragma once

#include "bake/pipeline/bake.h"

namespace fb::bake {

// bake_recorded, unless the work folder holds the whole of an earlier call's result for the same poses, options and
// version: then that, so that an interrupted comparison goes on where it stopped.
Baked cached_bake(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
