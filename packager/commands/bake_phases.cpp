#include "commands/bake_phases.h"

#include "commands/time_left.h"

#include <algorithm>
#include <iterator>

namespace fb::tool {
namespace {

struct Phase {
  const char* name;
  double share;          // of the time of a whole bake
  double stages;         // that it usually has
  const char* begin[9];  // what the names of its stages begin with
};

// Rounded from what `facebaker bake sample --poses 4000` tells with --recipe hero.
constexpr Phase phases[] = {
    {"sampling poses",
     0.05,
     4,
     {"starting the rig", "timing the rig", "evaluating single", "looking for jumps", "sampling poses",
      "reading evaluations", "copying evaluations", "exact poses", "evaluating kept"}},
    {"analysing the rig",
     0.5,
     100,
     {"evaluating", "validating", "measuring activation", "measuring residuals", "ranking", "fitting", "looking for",
      "reducing"}},
    {"training", 0.35, 7, {"looking for local", "finding local", "projecting", "training", "measuring local"}},
    {"packing", 0.05, 2, {"rounding", "packing", "fitting bytes", "repacking"}},
    {"measuring", 0.05, 9, {"measuring", "evaluating poses again"}},
    {"drawing", 0.0, 1, {"drawing"}},
};

constexpr std::size_t phase_count = std::size(phases), training_phase = 2;

// The phase that a stage is of, by the longest beginning that fits; `current` for a stage that none is known of.
std::size_t phase_of(std::string_view stage, std::size_t current) {
  std::size_t found = current, longest = 0;
  for (std::size_t p = 0; p < phase_count; ++p)
    for (const char* begin : phases[p].begin)
      if (begin && stage.starts_with(begin) && std::string_view(begin).size() > longest) {
        found = p;
        longest = std::string_view(begin).size();
      }
  return found;
}

double share_before(std::size_t phase) {
  double share = 0;
  for (std::size_t p = 0; p < phase; ++p) share += phases[p].share;
  return share;
}

}  // namespace

bool BakePhases::begin(std::string_view stage) {
  const std::size_t phase = std::max(phase_, phase_of(stage, phase_));
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
  const double of_phase = stages / std::max(phases[phase_].stages, stages + 1);
  done_ = std::max(done_, share_before(phase_) + of_phase * phases[phase_].share);
}

std::string BakePhases::name() const {
  return begun_ ? phases[phase_].name : "";
}

std::optional<double> seconds_left(std::string_view phase, std::string_view stage, double stage_left, double gone) {
  std::size_t index = 0;
  while (index < phase_count && phases[index].name != phase) ++index;
  const bool decides = index == training_phase ? stage.starts_with("training") : index > training_phase;
  if (!decides || index == phase_count) return std::nullopt;
  const double to_come = std::max(0.0, 1 - share_before(index + 1));
  return stage_left + (gone + stage_left) * to_come / (1 - to_come);
}

}  // namespace fb::tool
