#include "bake/measure/expectation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fb::bake {
namespace {

// The place of each value among all, from 0; equal values have the mean of their places.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0, end; first < order.size(); first = end) {
    for (end = first + 1; end < order.size() && values[order[end]] == values[order[first]];) ++end;
    for (std::size_t i = first; i < end; ++i) ranks[order[i]] = static_cast<double>(first + end - 1) / 2;
  }
  return ranks;
}

// Pearson's correlation; 0 where one of them does not vary.
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n,
               mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

double share_within_two(const std::vector<double>& expected, const std::vector<double>& measured) {
  std::size_t within = 0;
  for (std::size_t i = 0; i < measured.size(); ++i)
    within += measured[i] <= 2 * expected[i] && expected[i] <= 2 * measured[i];
  return static_cast<double>(within) / static_cast<double>(measured.size());
}

}  // namespace

std::optional<Expectation> compare_expected_errors(MeasuredFace& posed, EvalReport& report, const Source& source) {
  const runtime::Evaluator& face = posed.evaluator();
  if (face.error_count() == 0) return std::nullopt;
  const std::size_t controls = face.control_count();
  const double diagonal = source.rest().diagonal();
  std::vector<float> errors(face.error_count());
  std::vector<double> expected, measured;
  Expectation result;
  for (ClipErrors& clip : report.clips) {
    const auto found = std::find_if(source.clips().begin(), source.clips().end(),
                                    [&](const Clip& other) { return other.name == clip.name; });
    for (std::size_t f = 0; f < clip.frames.size(); ++f) {
      FrameErrors& frame = clip.frames[f];
      face.expected_errors(&found->controls[f * controls], errors.data(), &frame.outside, posed.workspace());
      frame.expected = static_cast<float>(errors[0] / diagonal);
      result.outside += frame.outside > 0;
      if (found->kind != ClipKind::shot) continue;
      expected.push_back(frame.expected);
      measured.push_back(std::sqrt(frame.mse));
    }
  }
  result.frames = measured.size();
  if (measured.empty()) return result;
  result.rank = correlation(ranks(expected), ranks(measured));
  result.within_two = share_within_two(expected, measured);
  std::vector<double> sorted = measured;
  std::sort(sorted.begin(), sorted.end());
  result.constant_within_two =
      share_within_two(std::vector<double>(measured.size(), sorted[sorted.size() / 2]), measured);
  return result;
}

}  // namespace fb::bake
