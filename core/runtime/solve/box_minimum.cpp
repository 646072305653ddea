#include "runtime/solve/box_minimum.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

constexpr int most_rounds = 30;  // then steps are cut off at bounds
constexpr int sweeps = 20;
constexpr int patience = 3;  // rounds that exchange all unknowns without leaving fewer to exchange

std::size_t rounded_up(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

}  // namespace

BoxMinimum::BoxMinimum(std::size_t most, const PoseKernels& kernels, std::pmr::memory_resource& memory)
    : kernels_(kernels),
      factor_(most, kernels, memory),
      matrix_(most * factor_.row_stride(), &memory),
      gradient_(factor_.row_stride(), &memory),
      lower_(most, &memory),
      upper_(most, &memory),
      step_(factor_.row_stride(), &memory),
      whole_(most * factor_.row_stride(), &memory),
      slopes_(factor_.row_stride(), &memory),
      held_(most, &memory),
      free_(&memory),
      factorised_(&memory),
      right_(factor_.row_stride(), &memory) {
  free_.reserve(most);
  factorised_.reserve(most);
}

void BoxMinimum::set_matrix(std::size_t count, float damping) {
  const std::size_t stride = row_stride();
  count_ = count;
  factorised_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const float* const from = matrix_.data() + i * stride;
    float* const to = whole_.data() + i * stride;
    std::copy_n(from, i + 1, to);
    to[i] += damping * to[i];
    for (std::size_t j = 0; j < i; ++j) whole_[j * stride + i] = from[j];
    std::fill(to + count, to + rounded_up(count), 0.0f);
  }
}

bool BoxMinimum::factorise_free() {
  if (free_ == factorised_) return true;
  const std::size_t stride = row_stride();
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const float* const from = whole_.data() + free_[i] * stride;
    float* const to = factor_.matrix() + i * stride;
    for (std::size_t j = i; j < free_.size(); ++j) to[j] = from[free_[j]];
  }
  factorised_.clear();
  if (!factor_.factorise(free_.size())) return false;
  factorised_ = free_;
  return true;
}

// The step of the free unknowns with the others at their bounds, and slopes_.
bool BoxMinimum::find_free() {
  const std::size_t stride = row_stride(), length = rounded_up(count_);
  free_.clear();
  std::fill_n(step_.begin(), stride, 0.0f);
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (held_[i] == Held::free) free_.push_back(i);
    step_[i] = held_[i] == Held::low ? lower_[i] : held_[i] == Held::high ? upper_[i] : 0;
  }
  if (!factorise_free()) return false;
  kernels_.dot_products(step_.data(), whole_.data(), stride, count_, length, slopes_.data());
  for (std::size_t i = 0; i < free_.size(); ++i) right_[i] = -(gradient_[free_[i]] + slopes_[free_[i]]);
  factor_.solve(right_.data());
  for (std::size_t i = 0; i < free_.size(); ++i) step_[free_[i]] = right_[i];
  kernels_.dot_products(step_.data(), whole_.data(), stride, count_, length, slopes_.data());
  for (std::size_t i = 0; i < count_; ++i) slopes_[i] += gradient_[i];
  return true;
}

// Whether an unknown that is free is beyond a bound, or one that is held would rather leave it.
bool BoxMinimum::belongs_elsewhere(std::size_t unknown, Held& to) const {
  const float step = step_[unknown], slope = slopes_[unknown];
  const float little = 1e-6f * std::fabs(gradient_[unknown]);
  switch (held_[unknown]) {
    case Held::free:
      to = step < lower_[unknown] ? Held::low : Held::high;
      return step < lower_[unknown] || step > upper_[unknown];
    case Held::low:
      to = Held::free;
      return slope < -little && lower_[unknown] < upper_[unknown];
    default:
      to = Held::free;
      return slope > little && lower_[unknown] < upper_[unknown];
  }
}

// Sweeps of the projected Gauss-Seidel method from no step: each unknown in turn goes to where it is best, between its
// bounds. They cost little and tell most of those that are held.
void BoxMinimum::guess_held() {
  const std::size_t length = rounded_up(count_);
  std::fill_n(step_.begin(), row_stride(), 0.0f);
  std::copy_n(gradient_.begin(), count_, slopes_.begin());
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t i = 0; i < count_; ++i) {
      const float* const row = whole_.data() + i * row_stride();
      const float best = step_[i] - slopes_[i] / row[i];
      const float to = std::min(std::max(best, lower_[i]), upper_[i]), change = to - step_[i];
      if (change == 0) continue;
      step_[i] = to;
      kernels_.add_rows(slopes_.data(), &change, row, 0, 1, length);
    }
  for (std::size_t i = 0; i < count_; ++i)
    held_[i] = step_[i] == lower_[i] ? Held::low : step_[i] == upper_[i] ? Held::high : Held::free;
}

bool BoxMinimum::solve() {
  guess_held();
  std::size_t fewest = count_ + 1;
  int left = patience;
  for (int round = 0; round < most_rounds; ++round) {
    if (!find_free()) return false;
    std::size_t wrong = 0, last = 0;
    Held to = Held::free;
    for (std::size_t i = 0; i < count_; ++i)
      if (belongs_elsewhere(i, to)) {
        ++wrong;
        last = i;
      }
    if (wrong == 0) return true;
    left = wrong < fewest ? patience : left - 1;
    fewest = std::min(fewest, wrong);
    // Exchanging the last one alone comes to an end, if slowly.
    for (std::size_t i = left >= 0 ? 0 : last; i < count_; ++i)
      if (belongs_elsewhere(i, to)) held_[i] = to;
  }
  for (std::size_t i = 0; i < count_; ++i) step_[i] = std::min(std::max(step_[i], lower_[i]), upper_[i]);
  kernels_.dot_products(step_.data(), whole_.data(), row_stride(), count_, rounded_up(count_), slopes_.data());
  for (std::size_t i = 0; i < count_; ++i) slopes_[i] += gradient_[i];
  return true;
}

double BoxMinimum::decrease() const {
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum -= 0.5 * step_[i] * (double(gradient_[i]) + slopes_[i]);
  return sum;
}

bool BoxMinimum::find_variances() {
  factorised_.clear();
  for (std::size_t i = 0; i < count_; ++i)
    std::copy_n(whole_.begin() + std::ptrdiff_t(i * row_stride()), count_, factor_.matrix() + i * row_stride());
  if (!factor_.factorise(count_)) return false;
  factor_.inverse_diagonal(step_.data(), right_.data());
  return true;
}

}  // namespace fb::runtime
