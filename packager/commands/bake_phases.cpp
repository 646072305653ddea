#include "commands/bake_phases.h"

#include <algorithm>

namespace fb::tool {
namespace {

struct PhaseFacts {
  const char* name;
  double share;   // of the time of a whole bake
  double stages;  // that it usually has
};

// By Phase. Rounded from what `facebaker bake sample --recipe compact --poses 8000 --report` tells, where training has
// six short stages before its own.
constexpr PhaseFacts phases[] = {{"sampling poses", 0.07, 4}, {"analysing the rig", 0.3, 100}, {"training", 0.48, 20},
                                 {"packing", 0.07, 2},        {"measuring", 0.03, 9},          {"drawing", 0.05, 2}};
constexpr std::string_view longest_training = "training";  // the stage of it

const PhaseFacts& facts_of(Phase phase) {
  return phases[static_cast<std::size_t>(phase)];
}

double share_before(Phase phase) {
  double share = 0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(phase); ++p) share += phases[p].share;
  return share;
}

}  // namespace

bool BakePhases::begin(Phase of_stage, std::string_view stage) {
  const Phase phase = std::max(phase_, of_stage);
  const bool fresh = !begun_ || phase != phase_;
  stages_ = fresh ? 0 : stages_ + 1;
  phase_ = phase;
  begun_ = true;
  trains_ = trains_ || stage == longest_training;
  update(0);
  return fresh;
}

void BakePhases::update(double share) {
  const double stages = stages_ + std::clamp(share, 0.0, 1.0);
  // Where there are more stages than usual, each has less of what is left.
  const double of_phase = stages / std::max(facts_of(phase_).stages, stages + 1);
  done_ = std::max(done_, share_before(phase_) + of_phase * facts_of(phase_).share);
}

std::string BakePhases::name() const {
  return begun_ ? facts_of(phase_).name : "";
}

double BakePhases::share_after(Phase phase) const {
  const double drawing = draws_ ? 0 : facts_of(Phase::writing).share;
  return std::max(0.0, 1 - share_before(phase) - facts_of(phase).share - drawing);
}

std::optional<double> BakePhases::seconds_left(double stage_left, double gone) {
  if (!trains_) return std::nullopt;
  const double to_come = share_after(phase_);
  const double left = stage_left + (gone + stage_left) * to_come / (1 - to_come);
  if (left > 0) done_ = std::max(done_, gone / (gone + left));
  return left;
}

}  // namespace fb::tool
