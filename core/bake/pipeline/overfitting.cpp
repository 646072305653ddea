#include "bake/pipeline/overfitting.h"

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double most_ratio = 2, least_left = 0.05;

}  // namespace

std::optional<std::string> overfitting_note(const BakeStats& stats) {
  double trained = 0, held_back = 0, energy = 0, most = 0;
  const RegionStats* worst = nullptr;
  for (const RegionStats& region : stats.regions) {
    if (region.epochs.empty() || !(region.validation > 0)) continue;
    const double training = region.epochs.back().training, excess = region.energy * (region.validation - training);
    trained += region.energy * training;
    held_back += region.energy * region.validation;
    energy += region.energy;
    if (worst && excess <= most) continue;
    worst = &region;
    most = excess;
  }
  if (!worst || !(held_back > most_ratio * trained) || !(held_back > least_left * energy)) return std::nullopt;
  return format(
      "overfitting: the networks leave %.3g %% of what they were trained on and %.3g %% of what was held back (of "
      "squared motion): more poses, or fewer inputs, would help, most of all region \"%s\", which has %zu inputs for "
      "%zu poses",
      100 * trained / energy, 100 * held_back / energy, worst->name.c_str(), worst->inputs, worst->poses);
}

}  // namespace fb::bake
