// Random numbers by counter: the same everywhere, in any order.
#pragma once

#include <cstddef>
#include <cstdint>

namespace rigs::production {

class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t item) : state_(mixed(seed) ^ mixed(~item)) {}

  // Uniform in [0, 1).
  float unit() { return static_cast<float>(mixed(state_ += 0x9e3779b97f4a7c15u) >> 40) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * unit(); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(unit() * static_cast<float>(count)); }

 private:
  // SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace rigs::production
