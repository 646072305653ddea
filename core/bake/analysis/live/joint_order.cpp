#include "bake/analysis/live/joint_order.h"

#include <algorithm>
#include <limits>
#include <set>

namespace fb::bake {
namespace {

constexpr int most_passes = 20;

}  // namespace

JointOrder::JointOrder(std::span<const PairOfTurns> pairs) {
  std::set<std::uint32_t> controls;
  for (const PairOfTurns& pair : pairs) controls.insert({pair.a, pair.b});
  controls_.assign(controls.begin(), controls.end());
  const std::size_t count = controls_.size();
  first_.resize(count * count), together_.resize(count * count);
  const auto place = [&](std::uint32_t control) {
    return static_cast<std::size_t>(std::ranges::lower_bound(controls_, control) - controls_.begin());
  };
  for (const PairOfTurns& pair : pairs) {
    const std::size_t a = place(pair.a), b = place(pair.b);
    first_[a * count + b] = pair.a_first, first_[b * count + a] = pair.b_first;
    together_[a * count + b] = together_[b * count + a] = pair.summed;
  }
  for (std::size_t c = 0; c < count; ++c) insert(c);
  std::vector<std::size_t> earlier;
  for (int pass = 0; pass < most_passes && order_ != earlier; ++pass) {
    earlier = order_;
    for (std::size_t c = 0; c < count; ++c) {
      std::erase(order_, c);
      insert(c);
    }
  }
}

// Where it leaves least.
void JointOrder::insert(std::size_t control) {
  const std::size_t count = controls_.size();
  double left = 0;
  for (const std::size_t other : order_) left += first_[control * count + other];
  double least = left;
  std::size_t best = 0;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    left += first_[order_[i] * count + control] - first_[control * count + order_[i]];
    if (left < least) least = left, best = i + 1;
  }
  order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(best), control);
}

double JointOrder::left() const {
  double sum = 0;
  for (std::size_t i = 0; i < order_.size(); ++i)
    for (std::size_t k = i + 1; k < order_.size(); ++k) sum += first_[order_[i] * order_.size() + order_[k]];
  return sum;
}

// (count + 1) x (count + 1): what is left of places [row, column) of the order in one rotation.
std::vector<double> JointOrder::left_within() const {
  const std::size_t count = order_.size();
  std::vector<double> left((count + 1) * (count + 1));
  for (std::size_t end = 1; end <= count; ++end) {
    double with_last = 0;
    for (std::size_t begin = end; begin-- > 0;) {
      with_last += together_[order_[begin] * count + order_[end - 1]];
      left[begin * (count + 1) + end] = left[begin * (count + 1) + end - 1] + with_last;
    }
  }
  return left;
}

// Dynamic programming over where a rotation ends.
std::vector<std::vector<std::uint32_t>> JointOrder::rotations(double enough, std::size_t most) const {
  const std::size_t count = order_.size();
  const std::vector<double> within = left_within();
  std::vector<double> least(count + 1, std::numeric_limits<double>::max());  // of the first places, in what there is
  least[0] = 0;
  std::vector<std::vector<std::size_t>> begins;  // by rotation: of one that ends at a place
  while (begins.empty() || (least[count] > enough && begins.size() < std::min(most, count))) {
    std::vector<double> with_another(count + 1, std::numeric_limits<double>::max());
    std::vector<std::size_t>& begin_of = begins.emplace_back(count + 1);
    for (std::size_t end = 1; end <= count; ++end)
      for (std::size_t begin = 0; begin < end; ++begin)
        if (const double left = least[begin] + within[begin * (count + 1) + end]; left < with_another[end])
          with_another[end] = left, begin_of[end] = begin;
    least = std::move(with_another);
  }
  std::vector<std::vector<std::uint32_t>> rotations(begins.size());
  for (std::size_t r = rotations.size(), end = count; r-- > 0;) {
    const std::size_t begin = begins[r][end];
    for (std::size_t i = begin; i < end; ++i) rotations[r].push_back(controls_[order_[i]]);
    end = begin;
  }
  return rotations;
}

}  // namespace fb::bake
