#pragma once

#include "bake/sampling/active_sampling.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Two small networks that learn, from different first weights, what curves fitted to the recorded poses leave over on
// the whole face; they disagree by their squared distance, over D^2. Deterministic for any number of threads; the
// round is part of the seed.
TrainEnsemble network_ensemble(std::uint64_t seed, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
