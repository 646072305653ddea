// Asking a rig for the poses that teach most: those where networks trained alike but for their seeds differ
// (query by ensemble; Seung, Opper, Sompolinsky, COLT 1992).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "bake/sampling/sampling.h"

namespace fb::bake {

// How much an ensemble disagrees on each of `count` poses (count x controls, rig values): `count` numbers, none
// negative, larger where it is less sure. Called with at most 1,000 poses at a time, from one thread.
using EnsembleVariance = std::function<std::vector<float>(std::span<const float> controls, std::size_t count)>;

// Picks `count` poses of a pool (poses x controls), as numbers within the pool, ascending. The pool is cut in ten by
// how far poses are from rest altogether, so that the largest do not take all; each tenth gives its poses of most
// variance, as many as the roots of its scores ask for. Of poses whose same controls are far along toward the same
// ends at most two in a hundred of the pick are taken so, and a `random_share` (0..1) is drawn evenly from what is
// left: what the ensemble is wrong about together is asked too. Fails with invalid_argument if the pool holds fewer
// poses, with not_finite on a score that is no number >= 0.
std::vector<std::uint32_t> select_poses(const RigSchema& schema, std::span<const float> pool, std::size_t count,
                                        double random_share, const EnsembleVariance& variance, std::uint64_t seed);

struct ActiveSamplingOptions {
  std::uint32_t rounds = 4;   // after the first poses, which are drawn without an ensemble
  double first_share = 0.5;   // of the new poses that are drawn so
  double random_share = 0.1;  // of every round
  std::uint32_t pool = 4;     // candidates of a round for each pose chosen
};

// Trains an ensemble on what was recorded so far, before round `round` (from 0). The source is gone after the call.
using TrainEnsemble = std::function<EnsembleVariance(Source& recorded, std::uint32_t round)>;

// As `sample`, but only the first share of the poses follows the plan; the others are chosen in rounds of equal size
// among candidates drawn from the same mix, each round a clip "chosen_N" of split train at the end of the dataset. A
// folder begun with the same options is continued at the round it was stopped in. Deterministic as far as the ensemble
// is. The probe of the rig is asked once a call.
SampleReport sample_actively(RigEvaluator& rig, const SamplingOptions& options, const ActiveSamplingOptions& choice,
                             const TrainEnsemble& ensemble, const std::filesystem::path& directory, Progress& progress);

}  // namespace fb::bake
