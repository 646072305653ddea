// Captured values as values of a face's controls.
#pragma once

#include <facebaker/facebaker.h>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration.h"

namespace fb::tool {

// The value that a captured coefficient, where 0 is rest and 1 the whole expression, is of a control: the coefficient
// itself, or where the control has a unit the part of the way from rest to the upper end of its range. Not clamped.
double control_value(const fb_control& control, double coefficient);

struct CapturedControl {
  std::size_t control = 0;  // of the face
  std::size_t name = 0;     // of the captured ones
};

// Which controls move by which captured names. A name is that of a control's ARKit label or else its own, by
// match_names; the expressions of VRM 0.x and 1.0 have both of their names ("joy", "happy"). Of several names for one
// control the last counts, which is that of the program that sends now.
class CaptureMapping {
 public:
  // `controls`, and what their strings point at, outlive it.
  explicit CaptureMapping(std::vector<fb_control> controls);

  // Finds the controls of these names, where they are others than before.
  void match(const std::vector<std::string>& names);

  const std::vector<fb_control>& controls() const { return controls_; }
  const std::vector<CapturedControl>& captured() const { return captured_; }
  // Names that move no control.
  const std::vector<std::string>& unmatched() const { return unmatched_; }

  // A value for each of captured(), calibrated and clamped to the range of its control: finite, whatever `values` are.
  // `values`: of the names that were matched.
  std::vector<float> apply(std::span<const float> values, const CaptureCalibration& calibration) const;

 private:
  std::vector<fb_control> controls_;
  std::vector<std::string> names_, unmatched_;
  std::vector<CapturedControl> captured_;
};

}  // namespace fb::tool
