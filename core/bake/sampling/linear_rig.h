#pragma once

#include <cstdint>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// Whether a live rig is a sum of blendshapes, as morph targets are: each control displaces vertices in proportion to
// how far it is towards an end of its range, whatever the others do. Found out in 64 random poses x with half of the
// controls off rest: f(x) is compared with f of two parts of them, f(a) + f(b) - f(rest), and (f(x) + f(rest)) / 2 with
// f half-way from rest. Deviations up to 1e-5 of the diagonal are roundings of floats. Stops at the first that is
// larger: most rigs are asked four poses. No if the rig fails in one.
bool is_linear(RigEvaluator& rig, std::uint64_t seed, Progress& progress);

}  // namespace fb::bake
