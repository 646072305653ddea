#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb::bake {

// Histogram of values >= 0, for their 99th percentile. Bins are given by the exponent and the leading six bits of the
// significand of a float: neighbours differ by at most 1/64. Takes 130 kB once something is counted.
class Histogram {
 public:
  void add(float value);
  void append(const Histogram& other);
  // 99th percentile, rounded up to the end of its bin; 0 without values.
  double p99() const;

 private:
  std::vector<std::uint64_t> bins_;
};

}  // namespace fb::bake
