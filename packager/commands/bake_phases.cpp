#include "commands/bake_phases.h"

#include <algorithm>

#include "commands/time_left.h"

namespace fb::tool {
namespace {

struct PhaseFacts {
  const char* name;
  double share;   // of the time of a whole bake
  double stages;  // that it usually has
};

// By Phase. Rounded from what `facebaker bake sample --poses 4000` tells with --recipe hero.
constexpr PhaseFacts phases[] = {{"sampling poses", 0.05, 4}, {"analysing the rig", 0.5, 100}, {"training", 0.35, 7},
                                 {"packing", 0.05, 2},        {"measuring", 0.05, 9},          {"drawing", 0.0, 1}};

const PhaseFacts& facts_of(Phase phase) {
  return phases[static_cast<std::size_t>(phase)];
}

double share_before(Phase phase) {
  double share = 0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(phase); ++p) share += phases[p].share;
  return share;
}

}  // namespace

bool BakePhases::begin(Phase of_stage) {
  const Phase phase = std::max(phase_, of_stage);
  const bool fresh = !begun_ || phase != phase_;
  stages_ = fresh ? 0 : stages_ + 1;
  phase_ = phase;
  begun_ = true;
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

std::optional<double> seconds_left(Phase phase, std::string_view stage, double stage_left, double gone) {
  if (phase < Phase::training || (phase == Phase::training && !stage.starts_with("training"))) return std::nullopt;
  const double to_come = std::max(0.0, 1 - share_before(phase) - facts_of(phase).share);
  return stage_left + (gone + stage_left) * to_come / (1 - to_come);
}

}  // namespace fb::tool
