#include "bake/sampling/coverage.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_training = 10000, most_target = 1000, most_pairs = 50;  // poses, for distances; pairs

// Poses with every control as a fraction of the way from rest to an end of its range, negative toward the minimum.
class NormalisedPoses {
 public:
  NormalisedPoses(const RigSchema& schema, std::span<const float> poses, const char* set)
      : width_(schema.control_count()), values_(poses.begin(), poses.end()) {
    if (values_.empty() || values_.size() % width_ != 0)
      fail(Status::invalid_argument, "coverage: %zu values are no %s poses of %zu controls", values_.size(), set,
           width_);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const Control& control = schema.controls[i % width_];
      const float away = values_[i] - control.rest,
                  room = (away < 0 ? control.rest - control.minimum : control.maximum - control.rest);
      values_[i] = room > 0 ? away / room : 0;
    }
  }
  std::size_t size() const { return values_.size() / width_; }
  float at(std::size_t pose, std::size_t control) const { return values_[pose * width_ + control]; }

 private:
  std::size_t width_;
  std::vector<float> values_;
};

// For each end of each control (2 c: minimum, 2 c + 1: maximum), the poses in which it is strongly active, as bits.
class StrongActivations {
 public:
  StrongActivations(const NormalisedPoses& poses, std::size_t controls)
      : words_((poses.size() + 63) / 64), size_(poses.size()), bits_(2 * controls * words_), counts_(1) {
    for (std::size_t pose = 0; pose < size_; ++pose) {
      std::size_t count = 0;
      for (std::size_t c = 0; c < controls; ++c) {
        const float position = poses.at(pose, c);
        if (std::abs(position) < strong_activation) continue;
        bits_[(2 * c + (position > 0)) * words_ + pose / 64] |= std::uint64_t{1} << pose % 64;
        ++count;
      }
      if (count >= counts_.size()) counts_.resize(count + 1);
      ++counts_[count];
    }
  }
  // Share of the poses in which both are.
  double share(std::size_t a, std::size_t b) const {
    std::size_t count = 0;
    for (std::size_t w = 0; w < words_; ++w)
      count += static_cast<std::size_t>(std::popcount(bits_[a * words_ + w] & bits_[b * words_ + w]));
    return static_cast<double>(count) / static_cast<double>(size_);
  }
  // [n]: poses with n controls strongly active.
  const std::vector<std::size_t>& counts() const { return counts_; }

 private:
  std::size_t words_, size_;
  std::vector<std::uint64_t> bits_;
  std::vector<std::size_t> counts_;
};

std::vector<PairCoverage> rank_pairs(const TrainingTarget<StrongActivations>& strong, std::size_t controls,
                                     const Parallel& parallel) {
  std::vector<std::size_t> ends;
  for (std::size_t end = 0; end < 2 * controls; ++end)
    if (strong[1].share(end, end) > 0) ends.push_back(end);
  std::vector<std::vector<PairCoverage>> found(ends.size());
  parallel_for(parallel, ends.size(), [&](std::size_t i, std::size_t) {
    for (std::size_t j = i + 1; j < ends.size(); ++j) {
      const std::size_t a = ends[i], b = ends[j];
      if (a / 2 == b / 2) continue;
      if (const double target = strong[1].share(a, b); target > 0)
        found[i].push_back({{static_cast<std::uint32_t>(a / 2), static_cast<std::uint32_t>(b / 2)},
                            {a % 2 == 1, b % 2 == 1},
                            {strong[0].share(a, b), target}});
    }
  });
  // Target over training share; the small term orders pairs without training poses by their target share.
  const auto under_represented = [](const PairCoverage& p) { return p.share[1] / (p.share[0] + 1e-3); };
  std::vector<PairCoverage> pairs;
  for (const std::vector<PairCoverage>& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  std::stable_sort(pairs.begin(), pairs.end(), [&](const PairCoverage& a, const PairCoverage& b) {
    return under_represented(a) > under_represented(b);
  });
  if (pairs.size() > most_pairs) pairs.resize(most_pairs);
  return pairs;
}

// Poses restricted to some controls, in units of their reach, without poses in which none of them moves.
struct RestrictedPoses {
  RestrictedPoses(const RigSchema& schema, const std::vector<std::size_t>& controls, std::span<const float> poses)
      : width(controls.size()) {
    for (std::size_t first = 0; first < poses.size(); first += schema.control_count()) {
      bool moves = false;
      for (const std::size_t c : controls) {
        const Control& control = schema.controls[c];
        values.push_back((poses[first + c] - control.rest) / control.reach());
        moves = moves || values.back() != 0;
      }
      if (!moves) values.resize(values.size() - width);
    }
  }
  std::size_t count() const { return values.size() / width; }
  const float* pose(std::size_t i) const { return values.data() + i * width; }

  // Distance of a pose restricted the same way to the nearest of these poses but number `except`, or to rest if that is
  // nearer.
  double nearest(const float* query, std::size_t except) const {
    float best = 0;
    for (std::size_t j = 0; j < width; ++j) best += query[j] * query[j];
    for (std::size_t i = 0; i < count(); ++i) {
      if (i == except) continue;
      float squares = 0;
      for (std::size_t k = 0; k < width && squares < best; k += 16)
        for (std::size_t j = k; j < std::min(k + 16, width); ++j) {
          const float d = query[j] - pose(i)[j];
          squares += d * d;
        }
      best = std::min(best, squares);
    }
    return std::sqrt(double(best));
  }

  std::size_t width;
  std::vector<float> values;
};

double quantile(std::vector<double> values, double fraction) {
  std::erase_if(values, [](double value) { return std::isnan(value); });  // ranges beyond what floats can subtract
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// At most `most` of the poses, evenly spaced.
std::vector<float> subsampled(std::span<const float> poses, std::size_t width, std::size_t most) {
  const std::size_t size = poses.size() / width, count = std::min(size, most);
  std::vector<float> some;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pose = poses.subspan(i * size / count * width, width);
    some.insert(some.end(), pose.begin(), pose.end());
  }
  return some;
}

void measure_groups(Coverage& coverage, const RigSchema& schema, std::span<const ControlGroup> groups,
                    std::span<const float> training, std::span<const float> target, const Parallel& parallel) {
  for (const ControlGroup& group : groups) {
    const RestrictedPoses known(schema, group.controls, training), queries(schema, group.controls, target);
    std::vector<double> among_training(std::min(known.count(), most_target)), to_training(queries.count());
    parallel_for(parallel, among_training.size(), [&](std::size_t i, std::size_t) {
      const std::size_t pose = i * known.count() / among_training.size();
      among_training[i] = known.nearest(known.pose(pose), pose);
    });
    parallel_for(parallel, to_training.size(),
                 [&](std::size_t i, std::size_t) { to_training[i] = known.nearest(queries.pose(i), known.count()); });
    GroupCoverage report{group.name, quantile(among_training, 0.5), quantile(among_training, 0.95),
                         quantile(to_training, 0.5), 0};
    const auto further = std::count_if(to_training.begin(), to_training.end(),
                                       [&](double distance) { return distance > report.percentile_95 + 1e-6; });
    if (further > 0) report.uncovered = static_cast<double>(further) / static_cast<double>(to_training.size());
    coverage.groups.push_back(std::move(report));
  }
  std::stable_sort(coverage.groups.begin(), coverage.groups.end(),
                   [](const GroupCoverage& a, const GroupCoverage& b) { return a.uncovered > b.uncovered; });
}

}  // namespace

Coverage measure_coverage(const RigSchema& schema, std::span<const ControlGroup> groups,
                          std::span<const float> training, std::span<const float> target, const Parallel& parallel) {
  const std::size_t width = schema.control_count();
  const TrainingTarget<NormalisedPoses> poses = {NormalisedPoses(schema, training, "training"),
                                                 NormalisedPoses(schema, target, "target")};
  const TrainingTarget<StrongActivations> strong = {StrongActivations(poses[0], width),
                                                    StrongActivations(poses[1], width)};
  Coverage coverage;
  coverage.controls.resize(width);
  for (const std::size_t set : {0, 1}) {
    coverage.poses[set] = poses[set].size();
    coverage.strong_counts[set] = strong[set].counts();
    for (std::size_t c = 0; c < width; ++c) {
      ControlCoverage& control = coverage.controls[c];
      for (std::size_t pose = 0; pose < poses[set].size(); ++pose) {
        control.lowest[set] = std::max(control.lowest[set], -poses[set].at(pose, c));
        control.highest[set] = std::max(control.highest[set], poses[set].at(pose, c));
      }
      control.strong[set] = strong[set].share(2 * c, 2 * c) + strong[set].share(2 * c + 1, 2 * c + 1);
    }
  }
  for (std::size_t c = 0; c < width; ++c) {
    std::size_t beyond = 0;
    for (std::size_t pose = 0; pose < poses[1].size(); ++pose)
      beyond += poses[1].at(pose, c) > coverage.controls[c].highest[0] + 1e-3f ||
                -poses[1].at(pose, c) > coverage.controls[c].lowest[0] + 1e-3f;
    coverage.controls[c].beyond = static_cast<double>(beyond) / static_cast<double>(poses[1].size());
  }
  coverage.pairs = rank_pairs(strong, width, parallel);
  measure_groups(coverage, schema, groups, subsampled(training, width, most_training),
                 subsampled(target, width, most_target), parallel);
  return coverage;
}

std::vector<float> pair_shares(const RigSchema& schema, std::span<const float> poses, const Parallel& parallel) {
  const std::size_t width = schema.control_count();
  const StrongActivations strong(NormalisedPoses(schema, poses, "training"), width);
  std::vector<float> shares(width * width);
  parallel_for(parallel, width, [&](std::size_t a, std::size_t) {
    for (std::size_t b = 0; b < width; ++b) {
      double share = 0;  // a control is active toward one end at a time
      for (const std::size_t one : {2 * a, 2 * a + 1})
        for (const std::size_t other : {2 * b, 2 * b + 1}) share += strong.share(one, other);
      shares[a * width + b] = static_cast<float>(share);
    }
  });
  return shares;
}

}  // namespace fb::bake
