#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

// What the size of a region's network depends on.
struct NetworkDemand {
  std::size_t inputs = 0, outputs = 0;
  double error = 0;  // that is expected of it, in squares
};

// Numbers in a network of `layers` hidden layers of this width.
std::size_t network_parameters(const NetworkDemand& demand, std::uint32_t layers, std::uint32_t width);

// One width a region, multiples of 16 from 32 to `widest`, so that all networks together have about `parameters`
// numbers. Widths grow with the cube root of the error: where an error falls with the
// square root of a network's numbers, that leaves the least in all.
std::vector<std::uint32_t> network_widths(std::span<const NetworkDemand> demands, std::uint32_t layers,
                                          std::uint32_t widest, std::size_t parameters);

}  // namespace fb::bake
