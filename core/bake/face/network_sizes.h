#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

// What the size of a region's network depends on.
struct NetworkDemand {
  std::size_t inputs = 0, outputs = 0;
  double error = 0;  // expected squared error
};

// Parameters of a network with `layers` hidden layers of this width.
std::size_t network_parameters(const NetworkDemand& demand, std::uint32_t layers, std::uint32_t width);

// The hidden width of each region's network: multiples of 16 from 32 to `max_width`, so that all networks together have
// at most `parameters` parameters (more if that takes widths below 32). Widths grow with the cube root of the expected
// error, which minimises the total where an error falls with the square root of a network's parameters.
std::vector<std::uint32_t> network_widths(std::span<const NetworkDemand> demands, std::uint32_t layers,
                                          std::uint32_t max_width, std::size_t parameters);

}  // namespace fb::bake
