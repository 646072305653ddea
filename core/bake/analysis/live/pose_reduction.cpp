#include "bake/analysis/live/pose_reduction.h"

#include <algorithm>

namespace fb::bake {

std::vector<std::uint32_t> active_controls(std::span<const float> pose, std::span<const float> rest) {
  std::vector<std::uint32_t> active;
  for (std::uint32_t c = 0; c < pose.size(); ++c)
    if (pose[c] != rest[c]) active.push_back(c);
  return active;
}

PoseReduction::PoseReduction(BadPose& bad, std::vector<std::uint32_t> order, std::span<const float> rest)
    : bad_(bad), active_(std::move(order)), rest_(rest), chunk_(std::max<std::size_t>(active_.size() / 2, 1)) {}

std::size_t PoseReduction::end() const {
  return std::min(at_ + chunk_, active_.size());
}

void PoseReduction::fill(std::span<float> pose) const {
  std::copy(bad_.pose.begin(), bad_.pose.end(), pose.begin());
  for (std::size_t k = at_; k < end(); ++k) pose[active_[k]] = rest_[active_[k]];
}

void PoseReduction::advance(double residual) {
  if (residual >= bad_.residual / 2) {
    for (std::size_t k = at_; k < end(); ++k) bad_.pose[active_[k]] = rest_[active_[k]];
    active_.erase(active_.begin() + std::ptrdiff_t(at_), active_.begin() + std::ptrdiff_t(end()));
    changed_ = true;
  } else {
    at_ += chunk_;
  }
  if (at_ < active_.size()) return;
  done_ = chunk_ == 1 && !changed_;
  chunk_ = std::max<std::size_t>(std::min(chunk_, active_.size()) / 2, 1);
  at_ = 0;
  changed_ = false;
}

}  // namespace fb::bake
