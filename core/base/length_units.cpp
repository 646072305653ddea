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

std::string unusual_size_text(double diagonal, const std::string& unit) {
  constexpr double least = 0.01, most = 30;
  const std::optional<double> metres = metres_per(unit);
  if (!metres || (diagonal * *metres >= least && diagonal * *metres < most)) return {};
  return format(
      "the mesh is %.3g m large, by its unit (%s): if it is not meant to be, its errors in millimetres are not what "
      "they "
      "say (a dataset, a plugin and a scene of Blender name their unit; glTF counts in metres)",
      diagonal * *metres, unit.c_str());
}

}  // namespace fb
