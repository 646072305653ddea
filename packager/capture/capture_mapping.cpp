#include "capture/capture_mapping.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "base/match_names.h"

namespace fb::tool {
namespace {

// Expressions that VRM 1.0 calls otherwise than VRM 0.x. Names that differ by "Blink_L" and "blinkLeft" are alike for
// match_names.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> vrm_names = {{{"joy", "happy"},
                                                                                     {"sorrow", "sad"},
                                                                                     {"fun", "relaxed"},
                                                                                     {"a", "aa"},
                                                                                     {"i", "ih"},
                                                                                     {"u", "ou"},
                                                                                     {"e", "ee"},
                                                                                     {"o", "oh"}}};

bool same_letters(std::string_view a, std::string_view b) {
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(a, b, {}, small, small);
}

// The other version's name of an expression; "" where it has none.
std::string other_vrm_name(std::string_view name) {
  for (const auto& [old_name, new_name] : vrm_names) {
    if (same_letters(name, old_name)) return std::string(new_name);
    if (same_letters(name, new_name)) return std::string(old_name);
  }
  return "";
}

}  // namespace

double control_value(const fb_control& control, double coefficient) {
  const double rest = control.rest;
  return *control.unit ? rest + coefficient * (control.maximum - rest) : coefficient;
}

CaptureMapping::CaptureMapping(std::vector<fb_control> controls) : controls_(std::move(controls)) {}

void CaptureMapping::match(const std::vector<std::string>& names) {
  if (names == names_) return;
  names_ = names;
  captured_.clear();
  unmatched_.clear();
  std::vector<std::vector<std::string>> known;
  for (const fb_control& control : controls_)
    known.push_back({control.arkit, control.name, other_vrm_name(control.name)});
  const auto found = match_names(names, known);
  std::vector<std::optional<std::size_t>> mover(controls_.size());  // name
  for (std::size_t n = 0; n < names.size(); ++n)
    if (found[n]) mover[*found[n]] = n;
  for (std::size_t n = 0; n < names.size(); ++n)
    if (found[n] && mover[*found[n]] == n)
      captured_.push_back({*found[n], n});
    else
      unmatched_.push_back(names[n]);
}

std::vector<float> CaptureMapping::apply(std::span<const float> values, const CaptureCalibration& calibration) const {
  std::vector<float> applied;
  for (const auto& [index, name] : captured_) {
    const fb_control& control = controls_[index];
    const double coefficient = calibration.apply(names_[name], values[name]);
    applied.push_back(
        static_cast<float>(std::clamp<double>(control_value(control, coefficient), control.minimum, control.maximum)));
  }
  return applied;
}

}  // namespace fb::tool
