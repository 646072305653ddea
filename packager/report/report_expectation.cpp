// The section of expected errors beside measured ones.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/status.h"
#include "report/plot.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

constexpr std::size_t most_groups = 40, frames_a_group = 10;

struct FramePair {
  double expected, measured;  // over D
};

std::vector<FramePair> frame_pairs(const MethodReport& method) {
  std::vector<FramePair> pairs;
  for (const ClipErrors& clip : method.independent.clips)
    for (std::size_t f = 0; clip.kind == "shot" && f < clip.frames.size(); ++f)
      pairs.push_back({clip.frames[f].expected, std::sqrt(double(clip.frames[f].mse))});
  return pairs;
}

// Frames in groups of similar expected errors: the middle of what was measured in each, and its limits.
Plot plot_expectation(std::vector<FramePair> pairs) {
  Plot plot{"Measured by expected error", "expected rms / D", "measured rms / D", {}, true, true};
  plot.curves = {{"half and twice", {}, {}, 0, true},
                 {"", {}, {}, 0, true},
                 {"95 of 100 frames", {}, {}, 2},
                 {"", {}, {}, 2},
                 {"middle", {}, {}, 1}};
  const auto by_expected = [](const FramePair& a, const FramePair& b) { return a.expected < b.expected; };
  const auto by_measured = [](const FramePair& a, const FramePair& b) { return a.measured < b.measured; };
  std::stable_sort(pairs.begin(), pairs.end(), by_expected);
  const std::size_t groups = std::clamp<std::size_t>(pairs.size() / frames_a_group, 1, most_groups);
  for (std::size_t g = 0; g < groups; ++g) {
    const auto begin = pairs.begin() + std::ptrdiff_t(g * pairs.size() / groups),
               end = pairs.begin() + std::ptrdiff_t((g + 1) * pairs.size() / groups);
    const std::size_t count = static_cast<std::size_t>(end - begin);
    const double expected = begin[std::ptrdiff_t(count / 2)].expected;
    std::stable_sort(begin, end, by_measured);
    const double ys[] = {expected / 2, expected * 2, begin[std::ptrdiff_t(count / 40)].measured,
                         begin[std::ptrdiff_t(count - 1 - count / 40)].measured,
                         begin[std::ptrdiff_t(count / 2)].measured};
    for (std::size_t c = 0; c < plot.curves.size(); ++c) {
      plot.curves[c].x.push_back(expected);
      plot.curves[c].y.push_back(ys[c]);
    }
  }
  return plot;
}

}  // namespace

void add_expectation(Html& page, const ReportView& view) {
  const std::vector<FramePair> pairs = frame_pairs(view.ours());
  if (!view.ours().independent.expectation || pairs.empty()) return;
  const Expectation& expected = *view.ours().independent.expectation;
  page.folded_heading("Expected error");
  page.paragraph(format(
      "What the face itself expects of each frame, before anything is measured: for %llu frames of shots that were not "
      "trained on, the rank correlation with the measured error is %.2f, and %.1f %% of them are within a factor of "
      "two "
      "(%.1f %% of the same constant error for all).",
      static_cast<unsigned long long>(expected.frames), expected.rank, 100 * expected.within_two,
      100 * expected.constant_within_two));
  if (expected.outside > 0)
    page.paragraph(format("In %llu of the measured frames a control is outside of what was trained.",
                          static_cast<unsigned long long>(expected.outside)));
  page.raw(draw_plot(plot_expectation(pairs)));
}

}  // namespace fb::tool
