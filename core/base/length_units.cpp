#include "base/length_units.h"

#include <utility>

#include "base/status.h"

namespace fb {

std::optional<double> metres_per(const std::string& unit) {
  constexpr std::pair<const char*, double> known[] = {{"m", 1},       {"dm", 0.1},      {"cm", 0.01},  {"mm", 0.001},
                                                      {"in", 0.0254}, {"inch", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : known)
    if (unit == name) return metres;
  return std::nullopt;
}

std::string length_text(double length, const std::string& unit) {
  if (const std::optional<double> metres = metres_per(unit)) return format("%.3g mm", 1e3 * *metres * length);
  return unit.empty() ? format("%.3g", length) : format("%.3g %s", length, unit.c_str());
}

}  // namespace fb
