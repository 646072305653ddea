#pragma once

#include <span>

#include "bake/rig/source.h"
#include "base/parallel.h"

namespace fb::bake {

// source.evaluate, spread over threads in blocks if the source is thread-safe. The points do not depend on the number
// of threads; neither does the failure, which is that of the first failing pose, numbered within this call.
void evaluate_parallel(Source& source, std::span<const float> controls, std::size_t count, std::span<float> points,
                       const Parallel& parallel);

}  // namespace fb::bake
