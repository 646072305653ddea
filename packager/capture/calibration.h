// What a performer's face is like at rest and how far it goes, as a capture program sees it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fb::tool {

struct CalibratedName {
  float neutral = 0;  // the captured value of the relaxed face
  float range = 1;    // that of the whole expression, above `neutral` by least_range or more
};

inline constexpr float least_range = 0.1F;

// By captured name: "jawOpen".
struct CaptureCalibration {
  std::map<std::string, CalibratedName, std::less<>> names;

  // value = (raw - neutral) / (range - neutral); the raw value of a name that is not calibrated. The value of the
  // control that comes of it is clamped to the control's own range.
  double apply(std::string_view name, float raw) const;
};

// The JSON document {"format": "facebaker-capture-calibration", "version": 1, "names": {"jawOpen": {"neutral": 0.02,
// "range": 0.7}}} and back. Reading fails with bad_data, naming the field, on what is missing, unknown or out of range.
std::string calibration_text(const CaptureCalibration& calibration);
CaptureCalibration parse_calibration(std::string_view text);
// The same of a file, whose path a failure names; it is written complete or not at all.
void write_calibration(const std::filesystem::path& path, const CaptureCalibration& calibration);
CaptureCalibration read_calibration(const std::filesystem::path& path);

}  // namespace fb::tool
