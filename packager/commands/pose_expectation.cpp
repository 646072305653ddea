#include "commands/pose_expectation.h"

#include <algorithm>
#include <vector>

#include "base/status.h"

namespace fb::tool {

std::optional<PoseExpectation> expect_errors(const facebaker::Model& model, const Poses& poses) {
  const std::size_t regions = fb_error_region_count(model.get());
  if (regions == 0) return std::nullopt;
  facebaker::Scratch scratch(model);
  std::vector<float> errors(1 + regions);
  PoseExpectation expected;
  for (std::size_t f = 0; f < poses.frames; ++f) {
    std::uint32_t outside = 0;
    facebaker::check(fb_expected_error(model.get(), scratch.get(), &poses.controls[f * model.control_count()],
                                       errors.data(), &outside));
    expected.largest = std::max(expected.largest, double(errors[0]));
    expected.outside += outside > 0;
  }
  return expected;
}

std::optional<std::string> outside_warning(const PoseExpectation& expected, std::size_t poses) {
  if (expected.outside == 0) return std::nullopt;
  return format(
      "warning: in %zu of %zu poses, controls are beyond the values they were trained to, or together as they never "
      "were: errors may be larger than expected",
      expected.outside, poses);
}

}  // namespace fb::tool
