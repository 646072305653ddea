#include "bake/face/network_sizes.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {

std::size_t network_parameters(const NetworkDemand& demand, std::uint32_t layers, std::uint32_t width) {
  const std::size_t w = width;
  return (demand.inputs + 1) * w + (layers - 1) * (w + 1) * w + (w + 1) * demand.outputs;
}

std::vector<std::uint32_t> network_widths(std::span<const NetworkDemand> demands, std::uint32_t layers,
                                          std::uint32_t max_width, std::size_t parameters) {
  constexpr std::uint32_t step = 16, min_width = 32;
  std::vector<std::uint32_t> widths(demands.size());
  double max_error = 0;
  for (const NetworkDemand& demand : demands) max_error = std::max(max_error, demand.error);
  // The largest width of the region with the most error that fits; the others follow in proportion.
  for (std::uint32_t widest = std::max(max_width / step, min_width / step) * step;; widest -= step) {
    std::size_t total = 0;
    for (std::size_t r = 0; r < demands.size(); ++r) {
      const double ratio = max_error > 0 ? std::pow(demands[r].error / max_error, 1.0 / 3) : 1;
      const auto steps = static_cast<std::uint32_t>(std::lround(widest * ratio / step));
      widths[r] = std::clamp(steps * step, min_width, std::max(widest, min_width));
      total += network_parameters(demands[r], layers, widths[r]);
    }
    if (total <= parameters || widest <= min_width) return widths;
  }
}

}  // namespace fb::bake
