// Fewer bytes for a face that is packed already.
#pragma once

#include <cstdint>
#include <functional>

#include "model/packed_model.h"

namespace fb::bake {

// The same face with every step of its basis `factor` (1 or more) times as large; columns that become 0 on a whole
// group leave it. Networks stay as they are.
PackedModel with_scaled_steps(const PackedModel& model, double factor);

struct StepScaling {
  double factor = 1;
  std::uint64_t bytes = 0;
  double error = 0;
};

// Goes down a ladder of factors from 1 to 1024 by bisection, taking bytes to fall and the error to grow along it: the
// first within max_bytes, or, if that is 0, the last within max_error. What cannot be had is approached. Measures each
// factor once.
StepScaling choose_step_scaling(std::uint64_t max_bytes, double max_error,
                                const std::function<std::uint64_t(double)>& bytes,
                                const std::function<double(double)>& error);

}  // namespace fb::bake
