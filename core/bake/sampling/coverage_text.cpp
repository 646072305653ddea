#include <algorithm>
#include <numeric>

#include "bake/sampling/coverage.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t lines = 10;  // of each list

// Share of the poses with `from` to `to` controls strongly active.
double share_of(const std::vector<std::size_t>& counts, std::size_t from, std::size_t to) {
  std::size_t count = 0, all = 0;
  for (std::size_t n = 0; n < counts.size(); ++n) {
    all += counts[n];
    if (n >= from && n <= to) count += counts[n];
  }
  return static_cast<double>(count) / static_cast<double>(all);
}

std::string counts_text(const Coverage& coverage) {
  std::string text = "\n  controls strongly active     training     target\n";
  const std::size_t most = std::max(coverage.strong_counts[0].size(), coverage.strong_counts[1].size()) - 1;
  for (std::size_t from = 0, to = 0; from <= most;
       from = to + 1, to = std::max<std::size_t>(1, 2 * from) - (from > 0)) {
    const std::string range = from == to ? format("%zu", from) : format("%zu to %zu", from, to);
    text += format("%26s  %10.2f%% %9.2f%%\n", range.c_str(), 100 * share_of(coverage.strong_counts[0], from, to),
                   100 * share_of(coverage.strong_counts[1], from, to));
  }
  return text;
}

std::string groups_text(const Coverage& coverage) {
  std::string text =
      "\nmedian distance to the nearest training pose, by control group; uncovered: target poses beyond the 95th "
      "percentile of training poses (5 % if alike)\n";
  for (const GroupCoverage& group : coverage.groups)
    text += format("%20s  training %.3f  target %.3f  uncovered %5.1f %%\n",
                   group.name.empty() ? "(no group)" : group.name.c_str(), group.median, group.target_median,
                   100 * group.uncovered);
  return text;
}

std::string controls_text(const Coverage& coverage, const RigSchema& schema) {
  std::vector<std::size_t> order(schema.control_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto beyond = [&](std::size_t c) { return coverage.controls[c].beyond; };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return beyond(a) > beyond(b); });
  std::string text;
  for (std::size_t i = 0; i < std::min(lines, order.size()) && beyond(order[i]) > 0; ++i) {
    const ControlCoverage& c = coverage.controls[order[i]];
    text += format("%28s  training %.2f to %.2f  target %.2f to %.2f  beyond in %.1f %% of the target poses\n",
                   schema.controls[order[i]].name.c_str(), -c.lowest[0], c.highest[0], -c.lowest[1], c.highest[1],
                   100 * c.beyond);
  }
  return text.empty() ? "\nno control exceeds its training range in the target poses\n"
                      : "\ncontrols that exceed their training range, as fractions of the way from rest\n" + text;
}

std::string pairs_text(const Coverage& coverage, const RigSchema& schema) {
  if (coverage.pairs.empty()) return "";
  std::string text = "\npairs strongly active at once, the most under-represented in training first\n";
  for (std::size_t i = 0; i < std::min(lines, coverage.pairs.size()); ++i) {
    const PairCoverage& pair = coverage.pairs[i];
    std::string names;
    for (const std::size_t k : {0, 1})
      names += (k ? ", " : "") + schema.controls[pair.controls[k]].name + (pair.up[k] ? "" : " down");
    text +=
        format("%44s  training %6.2f %%  target %6.2f %%\n", names.c_str(), 100 * pair.share[0], 100 * pair.share[1]);
  }
  return text;
}

}  // namespace

std::string coverage_text(const Coverage& coverage, const RigSchema& schema) {
  return format("%zu training poses, %zu target poses; strongly active: at least %g of the way from rest to an end\n",
                coverage.poses[0], coverage.poses[1], double(strong_activation)) +
         counts_text(coverage) + groups_text(coverage) + controls_text(coverage, schema) + pairs_text(coverage, schema);
}

}  // namespace fb::bake
