// Fewer bytes for a face that is packed already: larger quantisation steps of its basis.
#pragma once

#include <cstdint>
#include <functional>

#include "model/packed_model.h"

namespace fb::bake {

// The same face with every quantisation step of its basis `factor` (1 or more) times as large; columns that become 0 in
// a whole row block leave it. Networks stay as they are.
PackedModel with_scaled_steps(const PackedModel& model, double factor);

struct StepScaling {
  double factor = 1;
  std::uint64_t bytes = 0;
  double error = 0;
};
using MeasureScaling = std::function<StepScaling(double factor)>;

// Both bisect a geometric ladder of factors from 1 to 1024, four to a doubling, and take bytes to fall and the error to
// grow along it. `measure` is called more than once with the same factor.

// The smallest factor whose bytes are at most max_bytes; 1024 if there is none.
StepScaling finest_within_bytes(std::uint64_t max_bytes, const MeasureScaling& measure);

// The largest factor whose error is at most max_error; 1 if there is none.
StepScaling coarsest_within_error(double max_error, const MeasureScaling& measure);

}  // namespace fb::bake
