#include "bake/rig/earlier_evaluations.h"

#include <algorithm>

namespace fb::bake {

EarlierEvaluations::EarlierEvaluations(EvaluationCache& cache, const RigSchema& before, const RigSchema& now)
    : cache_(cache), found_(before.control_count()) {
  for (const Control& control : now.controls) rest_.push_back(control.rest);
  for (const Control& old : before.controls) {
    const std::optional<std::size_t> place = now.find(old.name);
    if (place)
      earlier_.push_back({place, now.controls[*place].minimum, now.controls[*place].maximum});
    else
      earlier_.push_back({place, old.rest, old.rest});
  }
}

bool EarlierEvaluations::read(std::uint64_t record, std::span<float> controls, std::span<float> points) {
  if (earlier_.empty()) return cache_.read(record, controls, points);
  if (!cache_.read(record, found_, points)) return false;
  std::ranges::copy(rest_, controls.begin());
  for (std::size_t c = 0; c < earlier_.size(); ++c) {
    if (found_[c] < earlier_[c].minimum || found_[c] > earlier_[c].maximum) return false;
    if (earlier_[c].place) controls[*earlier_[c].place] = found_[c];
  }
  return true;
}

}  // namespace fb::bake
