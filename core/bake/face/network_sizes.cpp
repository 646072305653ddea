#include "bake/face/network_sizes.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {

std::size_t network_parameters(const NetworkDemand& demand, std::uint32_t layers, std::uint32_t width) {
  const std::size_t w = width;
  return (demand.inputs + 1) * w + (layers - 1) * (w + 1) * w + (w + 1) * demand.outputs;
}

std::vector<std::uint32_t> network_widths(std::span<const NetworkDemand> demands, std::uint32_t layers,
                                          std::uint32_t widest, std::size_t parameters) {
  constexpr std::uint32_t step = 16, narrowest = 32;
  std::vector<std::uint32_t> widths(demands.size());
  double most = 0;
  for (const NetworkDemand& demand : demands) most = std::max(most, demand.error);
  // The widest network that fits; the others follow in proportion.
  for (std::uint32_t lead = std::max(widest / step, narrowest / step) * step;; lead -= step) {
    std::size_t total = 0;
    for (std::size_t r = 0; r < demands.size(); ++r) {
      const double share = most > 0 ? std::pow(demands[r].error / most, 1.0 / 3) : 1;
      const auto steps = static_cast<std::uint32_t>(std::lround(lead * share / step));
      widths[r] = std::clamp(steps * step, narrowest, std::max(lead, narrowest));
      total += network_parameters(demands[r], layers, widths[r]);
    }
    if (total <= parameters || lead <= narrowest) return widths;
  }
}

}  // namespace fb::bake
