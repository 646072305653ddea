// Active sampling: evaluates the poses where networks trained alike but for their seeds differ most (query by
// committee; Seung, Opper, Sompolinsky, COLT 1992).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "bake/sampling/sampling.h"

namespace fb::bake {

// The variance of an ensemble in each of `count` poses (count x controls, rig values): `count` numbers, none negative.
// Called with at most 1,000 poses at a time, from one thread.
using EnsembleVariance = std::function<std::vector<float>(std::span<const float> controls, std::size_t count)>;

// Selects `count` poses of a pool (poses x controls), as numbers within the pool, ascending. The pool is cut into ten
// strata by the poses' distance from rest, so that the largest poses do not take all; each stratum gives its poses of
// most variance, in proportion to the sum of their standard deviations (Neyman allocation). At most two in a hundred of
// the selected poses have the same controls strongly active toward the same ends. A `random_share` (0..1) is drawn
// evenly from the rest, since an ensemble may be wrong without variance. Fails with invalid_argument if the pool holds
// fewer poses, with not_finite on a variance that is no number >= 0.
std::vector<std::uint32_t> select_poses(const RigSchema& schema, std::span<const float> pool, std::size_t count,
                                        double random_share, const EnsembleVariance& variance, std::uint64_t seed);

struct ActiveSamplingOptions {
  std::uint32_t rounds = 4;  // after the first poses, which are drawn without an ensemble
  // Of the new poses that are drawn so, beyond those of single controls within a budget. On a rig of 303 controls with
  // a budget of 3,000, hero left an mse of 1.4e-7, 5.6e-7 and 4.3e-7 with 0.25, 1.3e-7, 5.7e-7 and 4.3e-7 with 0.5, and
  // 1.5e-7, 6.4e-7 and 5.0e-7 with 0.8.
  double first_share = 0.5;
  double random_share = 0.1;  // of every round
  std::uint32_t pool = 4;     // candidates of a round for each pose selected
};

// How many new poses of a plan are drawn before the first round.
std::uint64_t poses_before_ensemble(const Source& rig, const SamplingOptions& options,
                                    const ActiveSamplingOptions& active);

// Trains an ensemble on what is recorded before round `round` (from 0). The source is gone after the call.
using TrainEnsemble = std::function<EnsembleVariance(Source& recorded, std::uint32_t round)>;

// As `sample`, but only the first share of the poses follows the plan; the others are selected in rounds of equal size
// among candidates drawn from the same mix, each round a clip "chosen_N" of split train at the end of the dataset. A
// folder begun with the same options is continued at the round in which it was interrupted. Deterministic as far as the
// ensemble is. The responses to single controls are evaluated at most once a call.
SampleReport sample_actively(RigEvaluator& rig, const SamplingOptions& options, const ActiveSamplingOptions& active,
                             const TrainEnsemble& ensemble, const std::filesystem::path& directory, Progress& progress);

}  // namespace fb::bake
