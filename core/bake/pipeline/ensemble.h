#pragma once

#include "bake/sampling/active_sampling.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// An ensemble of two small networks with different initial weights. Both learn the residual of the whole face to
// activation curves fitted to the recorded poses. The variance of a pose is their mean squared distance at a vertex,
// over D^2. Deterministic for any number of threads; the round is part of the seed.
TrainEnsemble network_ensemble(std::uint64_t seed, const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
