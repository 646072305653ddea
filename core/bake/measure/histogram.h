#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb::bake {

// Counts values >= 0 by the exponent and the six leading bits of the fraction of their float representation:
// neighbouring bins differ by at most 1/64. Takes 130 kB once something was counted.
class Histogram {
 public:
  void add(float value);
  void append(const Histogram& other);
  // What one value in a hundred may lie beyond, rounded up to the end of its bin; 0 without values.
  double p99() const;

 private:
  std::vector<std::uint64_t> bins_;
};

}  // namespace fb::bake
