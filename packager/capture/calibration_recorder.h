#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration.h"

namespace fb::tool {

// Finds a calibration in some seconds of capture: the performer holds the face relaxed first, then makes every
// expression as large as it gets. The neutral value of a name is the median of the first part. Its range is the third
// largest value of all, so that two frames that are off do not count; a name that moved by less than least_range keeps
// the range 1. Names in `turns` go to both sides: only their neutral value is found, and their range is 1 above that.
class CalibrationRecorder {
 public:
  // The first third of `seconds`, at most 3 seconds, is the relaxed part.
  CalibrationRecorder(double seconds, std::set<std::string> turns);

  double seconds() const { return seconds_; }
  double relaxed_seconds() const { return relaxed_seconds_; }

  // A frame that came so long after the first one. `names` only grow from call to call.
  void take(const std::vector<std::string>& names, std::span<const float> values, double seconds);

  CaptureCalibration calibration() const;
  // Names that hardly moved.
  std::vector<std::string> still_names() const;

 private:
  struct Recorded {
    std::vector<float> relaxed;  // of the first frames
    std::vector<float> largest;  // up to three, the largest first
  };
  bool is_still(std::size_t name) const;
  float neutral_of(std::size_t name) const;

  double seconds_, relaxed_seconds_;
  std::set<std::string> turns_;
  std::vector<std::string> names_;
  std::vector<Recorded> recorded_;  // of each name
};

}  // namespace fb::tool
