#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// Expected errors of a packed face: in which proportion controls cause them from (at most 2,000 of) its training poses,
// how large they are from those that nothing was fitted to; none with fewer than 30 of these. Regions are found by
// k-means from which controls move a row block; vertices that nothing moves are one more. Weights maximise the
// likelihood of the mean squared errors as gamma variables (of one shape and a mean that is the sum), by multiplicative
// updates (Fevotte, Idier: Algorithms for nonnegative matrix factorization with the beta-divergence, 2011, with beta =
// 0), with a prior worth a third of a pose that errors are in proportion to motion.
ExpectedErrors calibrate_errors(const PackedModel& model, const PoseSet& training,
                                std::span<const std::uint32_t> held_back, std::uint64_t seed, const Parallel& parallel);

// How far controls are from rest, from 0 to 1 at their reach: one number a control of each pose.
std::vector<float> reached(const RigSchema& schema, std::span<const float> poses);

// Weights of non-negative inputs whose sum predicts a value: one an input, then the constant. inputs: values x width;
// prior: expected weights, above 0, of which each counts as much as `prior_values` values.
std::vector<double> fit_nonnegative(std::span<const float> inputs, std::size_t width, std::span<const double> values,
                                    std::span<const double> prior, double prior_values);

}  // namespace fb::bake
