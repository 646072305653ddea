#include "bake/analysis/holdout_set.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fb::bake {
namespace {

std::vector<std::uint32_t> moved_by(const SparseBlendshapes& part) {
  std::vector<std::uint32_t> moved;
  for (const SparseShape& shape : part.shapes) moved.insert(moved.end(), shape.vertices.begin(), shape.vertices.end());
  std::sort(moved.begin(), moved.end());
  moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
  return moved;
}

}  // namespace

HoldoutSet::HoldoutSet(std::vector<float> controls, std::vector<float> residuals, std::vector<float> rest,
                       const Parallel& parallel, std::vector<std::uint32_t> judged)
    : controls_(std::move(controls)),
      residuals_(std::move(residuals)),
      rest_(std::move(rest)),
      judged_(std::move(judged)),
      parallel_(parallel),
      poses_(controls_.size() / rest_.size()),
      size_(poses_ ? residuals_.size() / poses_ : 0),
      scratch_(worker_count(parallel), std::vector<float>(size_)) {}

template <class Use>
void HoldoutSet::for_moved(const SparseBlendshapes& part, const Use& use) {
  if (judged_.empty())
    for_moved_by(part, use);
  else
    for_moved_by(part_of(part, judged_), use);
}

// part: of the vertices that are judged.
template <class Use>
void HoldoutSet::for_moved_by(const SparseBlendshapes& part, const Use& use) {
  const std::vector<std::uint32_t> moved = moved_by(part);
  parallel_for(parallel_, poses_, [&](std::size_t p, std::size_t worker) {
    const std::span<const float> pose = std::span(controls_).subspan(p * rest_.size(), rest_.size());
    std::vector<float> values(part.features.size());
    evaluate_features(part.features, pose, rest_, values);
    float* displacement = scratch_[worker].data();
    bool any = false;
    for (const SparseShape& shape : part.shapes) {
      if (values[shape.feature] == 0) continue;
      if (!any)
        for (const std::uint32_t v : moved) std::fill_n(displacement + 3 * v, 3, 0.0f);
      add_scaled(shape, values[shape.feature], scratch_[worker]);
      any = true;
    }
    float* residual = residuals_.data() + p * size_;
    if (any)
      for (const std::uint32_t v : moved) use(p, residual + 3 * v, displacement + 3 * v);
  });
}

void HoldoutSet::add(const SparseBlendshapes& part, float sign) {
  for_moved(part, [&](std::size_t, float* residual, const float* displacement) {
    for (int axis = 0; axis < 3; ++axis) residual[axis] -= sign * displacement[axis];
  });
}

double HoldoutSet::increase_without(const SparseBlendshapes& part) {
  std::vector<double> increase(poses_);
  for_moved(part, [&](std::size_t p, const float* residual, const float* displacement) {
    for (int axis = 0; axis < 3; ++axis)
      increase[p] += double(displacement[axis]) * (double(displacement[axis]) + 2 * double(residual[axis]));
  });
  return std::accumulate(increase.begin(), increase.end(), 0.0);
}

std::vector<bool> HoldoutSet::prune(std::span<const SparseBlendshapes* const> parts) {
  std::vector<bool> kept(parts.size(), true);
  // A part that helped beside another may not help once that has been removed.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (kept[p] && increase_without(*parts[p]) < 0) {
        add(*parts[p], -1);
        kept[p] = false;
        changed = true;
      }
  }
  return kept;
}

HoldoutSet::Error HoldoutSet::error() const {
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < residuals_.size(); i += 3) {
    const double squares = double(residuals_[i]) * residuals_[i] + double(residuals_[i + 1]) * residuals_[i + 1] +
                           double(residuals_[i + 2]) * residuals_[i + 2];
    sum += squares;
    largest = std::max(largest, squares);
  }
  return {residuals_.empty() ? 0 : std::sqrt(3 * sum / double(residuals_.size())), std::sqrt(largest)};
}

}  // namespace fb::bake
