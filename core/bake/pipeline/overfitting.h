#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "figures/training_figures.h"

namespace fb::bake {

// A sentence if the networks overfit: if they leave more than twice as much of validation poses as of those they were
// trained on, and more than 5 %. Squared coefficient errors over squared coefficients; regions count by their energy.
// None without validation poses, or after a training that was only resumed.
std::optional<std::string> overfitting_note(const BakeStats& stats);

}  // namespace fb::bake
