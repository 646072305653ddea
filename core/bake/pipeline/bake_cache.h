#pragma once

#include "bake/pipeline/bake.h"

namespace fb::bake {

// train_and_pack and the archive without a certificate. If the work folder holds the result of an earlier call for the
// same poses, options and version, that is returned: an interrupted comparison goes on where it stopped.
Baked cached_bake(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
