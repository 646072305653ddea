#include "capture/calibration_recorder.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace fb::tool {
namespace {

constexpr double longest_relaxed = 3;         // seconds
constexpr std::size_t relaxed_frames = 1024;  // that are kept
constexpr std::size_t kept_largest = 3;
constexpr float largest_captured = 100;  // of a coefficient that is about 1

}  // namespace

CalibrationRecorder::CalibrationRecorder(double seconds, std::set<std::string> turns)
    : seconds_(seconds), relaxed_seconds_(std::min(seconds / 3, longest_relaxed)), turns_(std::move(turns)) {}

void CalibrationRecorder::take(const std::vector<std::string>& names, std::span<const float> values, double seconds) {
  if (names.size() > names_.size()) names_ = names;
  recorded_.resize(names_.size());
  for (std::size_t n = 0; n < values.size(); ++n) {
    Recorded& recorded = recorded_[n];
    const float value = std::clamp(values[n], -largest_captured, largest_captured);
    if (seconds < relaxed_seconds_ && recorded.relaxed.size() < relaxed_frames) recorded.relaxed.push_back(value);
    const auto place = std::ranges::upper_bound(recorded.largest, value, std::greater<>());
    recorded.largest.insert(place, value);
    if (recorded.largest.size() > kept_largest) recorded.largest.pop_back();
  }
}

float CalibrationRecorder::neutral_of(std::size_t name) const {
  std::vector<float> values = recorded_[name].relaxed;
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

bool CalibrationRecorder::is_still(std::size_t name) const {
  return recorded_[name].largest.back() - neutral_of(name) < least_range;
}

CaptureCalibration CalibrationRecorder::calibration() const {
  CaptureCalibration calibration;
  for (std::size_t n = 0; n < names_.size(); ++n) {
    const float neutral = neutral_of(n);
    float range = recorded_[n].largest.back();
    if (turns_.contains(names_[n]))
      range = neutral + 1;
    else if (is_still(n))
      range = std::max(1.0F, neutral + least_range);
    calibration.names[names_[n]] = {neutral, range};
  }
  return calibration;
}

std::vector<std::string> CalibrationRecorder::still_names() const {
  std::vector<std::string> still;
  for (std::size_t n = 0; n < names_.size(); ++n)
    if (!turns_.contains(names_[n]) && is_still(n)) still.push_back(names_[n]);
  return still;
}

}  // namespace fb::tool
