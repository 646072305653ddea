#include "bake/sampling/coverage.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_trained = 10000, most_asked = 1000, most_pairs = 50;

// Poses as numbers a person compares: each control's part of the way from rest to either end, below 0 toward the
// minimum.
class WayPoses {
 public:
  WayPoses(const RigSchema& schema, std::span<const float> poses, const char* whose)
      : width_(schema.control_count()), values_(poses.begin(), poses.end()) {
    if (values_.empty() || values_.size() % width_ != 0)
      fail(Status::invalid_argument, "coverage: %zu values are no %s poses of %zu controls", values_.size(), whose,
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

// For each end of each control (2 c: minimum, 2 c + 1: maximum), in which poses it is far along.
class FarEnds {
 public:
  FarEnds(const WayPoses& poses, std::size_t controls)
      : words_((poses.size() + 63) / 64), size_(poses.size()), bits_(2 * controls * words_), together_(1) {
    for (std::size_t pose = 0; pose < size_; ++pose) {
      std::size_t count = 0;
      for (std::size_t c = 0; c < controls; ++c) {
        const float way = poses.at(pose, c);
        if (std::abs(way) < far_along) continue;
        bits_[(2 * c + (way > 0)) * words_ + pose / 64] |= std::uint64_t{1} << pose % 64;
        ++count;
      }
      if (count >= together_.size()) together_.resize(count + 1);
      ++together_[count];
    }
  }
  // Share of the poses in which both ends are reached.
  double share(std::size_t a, std::size_t b) const {
    std::size_t count = 0;
    for (std::size_t w = 0; w < words_; ++w)
      count += static_cast<std::size_t>(std::popcount(bits_[a * words_ + w] & bits_[b * words_ + w]));
    return static_cast<double>(count) / static_cast<double>(size_);
  }
  const std::vector<std::size_t>& together() const { return together_; }

 private:
  std::size_t words_, size_;
  std::vector<std::uint64_t> bits_;
  std::vector<std::size_t> together_;
};

std::vector<PairCoverage> rank_pairs(const TrainedAsked<FarEnds>& far, std::size_t controls, const Parallel& parallel) {
  std::vector<std::size_t> ends;
  for (std::size_t end = 0; end < 2 * controls; ++end)
    if (far[1].share(end, end) > 0) ends.push_back(end);
  std::vector<std::vector<PairCoverage>> found(ends.size());
  parallel_for(parallel, ends.size(), [&](std::size_t i, std::size_t) {
    for (std::size_t j = i + 1; j < ends.size(); ++j) {
      const std::size_t a = ends[i], b = ends[j];
      if (a / 2 == b / 2) continue;
      if (const double asked = far[1].share(a, b); asked > 0)
        found[i].push_back({{static_cast<std::uint32_t>(a / 2), static_cast<std::uint32_t>(b / 2)},
                            {a % 2 == 1, b % 2 == 1},
                            {far[0].share(a, b), asked}});
    }
  });
  // Asked over trained; a thousandth keeps the rarely asked behind the often asked among those never trained.
  const auto lack = [](const PairCoverage& p) { return p.share[1] / (p.share[0] + 1e-3); };
  std::vector<PairCoverage> pairs;
  for (const std::vector<PairCoverage>& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  std::stable_sort(pairs.begin(), pairs.end(),
                   [&](const PairCoverage& a, const PairCoverage& b) { return lack(a) > lack(b); });
  if (pairs.size() > most_pairs) pairs.resize(most_pairs);
  return pairs;
}

// Poses seen through some controls, in units of their reach; poses in which none of them moves are left out.
struct View {
  View(const RigSchema& schema, const std::vector<std::size_t>& controls, std::span<const float> poses)
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

  // Distance of a pose seen the same way to the nearest pose of this view but number `except`, or to rest if that is
  // nearer.
  double nearest(const float* wanted, std::size_t except) const {
    float best = 0;
    for (std::size_t j = 0; j < width; ++j) best += wanted[j] * wanted[j];
    for (std::size_t i = 0; i < count(); ++i) {
      if (i == except) continue;
      float squares = 0;
      for (std::size_t k = 0; k < width && squares < best; k += 16)
        for (std::size_t j = k; j < std::min(k + 16, width); ++j) {
          const float d = wanted[j] - pose(i)[j];
          squares += d * d;
        }
      best = std::min(best, squares);
    }
    return std::sqrt(double(best));
  }

  std::size_t width;
  std::vector<float> values;
};

double part_of(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// At most `most` of the poses, evenly spaced.
std::vector<float> subsampled(std::span<const float> poses, std::size_t width, std::size_t most) {
  const std::size_t size = poses.size() / width, count = std::min(size, most);
  std::vector<float> thin;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pose = poses.subspan(i * size / count * width, width);
    thin.insert(thin.end(), pose.begin(), pose.end());
  }
  return thin;
}

void measure_regions(Coverage& coverage, const RigSchema& schema, std::span<const ControlGroup> regions,
                     std::span<const float> trained, std::span<const float> asked, const Parallel& parallel) {
  for (const ControlGroup& region : regions) {
    const View known(schema, region.controls, trained), wanted(schema, region.controls, asked);
    std::vector<double> among(std::min(known.count(), most_asked)), to_asked(wanted.count());
    parallel_for(parallel, among.size(), [&](std::size_t i, std::size_t) {
      const std::size_t pose = i * known.count() / among.size();
      among[i] = known.nearest(known.pose(pose), pose);
    });
    parallel_for(parallel, to_asked.size(),
                 [&](std::size_t i, std::size_t) { to_asked[i] = known.nearest(wanted.pose(i), known.count()); });
    GroupCoverage report{region.name, part_of(among, 0.5), part_of(among, 0.95), part_of(to_asked, 0.5), 0};
    const auto further = std::count_if(to_asked.begin(), to_asked.end(),
                                       [&](double distance) { return distance > report.usual + 1e-6; });
    if (further > 0) report.uncovered = static_cast<double>(further) / static_cast<double>(to_asked.size());
    coverage.regions.push_back(std::move(report));
  }
  std::stable_sort(coverage.regions.begin(), coverage.regions.end(),
                   [](const GroupCoverage& a, const GroupCoverage& b) { return a.uncovered > b.uncovered; });
}

}  // namespace

Coverage measure_coverage(const RigSchema& schema, std::span<const ControlGroup> regions,
                          std::span<const float> trained, std::span<const float> asked, const Parallel& parallel) {
  const std::size_t width = schema.control_count();
  const TrainedAsked<WayPoses> ways = {WayPoses(schema, trained, "trained"), WayPoses(schema, asked, "asked")};
  const TrainedAsked<FarEnds> far = {FarEnds(ways[0], width), FarEnds(ways[1], width)};
  Coverage coverage;
  coverage.controls.resize(width);
  for (const std::size_t set : {0, 1}) {
    coverage.poses[set] = ways[set].size();
    coverage.far_together[set] = far[set].together();
    for (std::size_t c = 0; c < width; ++c) {
      ControlCoverage& control = coverage.controls[c];
      for (std::size_t pose = 0; pose < ways[set].size(); ++pose) {
        control.lowest[set] = std::max(control.lowest[set], -ways[set].at(pose, c));
        control.highest[set] = std::max(control.highest[set], ways[set].at(pose, c));
      }
      control.far[set] = far[set].share(2 * c, 2 * c) + far[set].share(2 * c + 1, 2 * c + 1);
    }
  }
  for (std::size_t c = 0; c < width; ++c) {
    std::size_t beyond = 0;
    for (std::size_t pose = 0; pose < ways[1].size(); ++pose)
      beyond += ways[1].at(pose, c) > coverage.controls[c].highest[0] + 1e-3f ||
                -ways[1].at(pose, c) > coverage.controls[c].lowest[0] + 1e-3f;
    coverage.controls[c].beyond = static_cast<double>(beyond) / static_cast<double>(ways[1].size());
  }
  coverage.pairs = rank_pairs(far, width, parallel);
  measure_regions(coverage, schema, regions, subsampled(trained, width, most_trained),
                  subsampled(asked, width, most_asked), parallel);
  return coverage;
}

}  // namespace fb::bake
