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

ShownUnit shown_unit(const std::string& unit) {
  if (const std::optional<double> metres = metres_per(unit)) return {1e3 * *metres, "mm"};
  return {1, unit.empty() ? "units" : unit};
}

std::string length_text(double length, const std::string& unit) {
  const ShownUnit shown = shown_unit(unit);
  const double value = shown.per_unit * length;
  return format(value < 999.5 ? "%.3g" : "%.0f", value) + (unit.empty() ? "" : " " + shown.name);
}

}  // namespace fb
