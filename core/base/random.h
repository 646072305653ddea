// Seeded random numbers that do not depend on the standard library, the thread count or the order of work:
// every item of work opens its own stream (seed, stream number).
#pragma once

#include <cstdint>

namespace fb {

class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix(mix(seed) ^ (stream + 1))) {}

  // 64 random bits: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
  std::uint64_t next() { return mix(state_ += golden); }

  // [0, 1), 24 bits.
  float uniform() { return static_cast<float>(next() >> 40) * 0x1p-24f; }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }

  // [0, count), count > 0; bias below count / 2^32.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(((next() >> 32) * count) >> 32); }

  // Close to normal with mean 0 and deviation 1: the centred sum of 12 uniforms (Irwin-Hall), libm-free, in [-6, 6].
  float normal() {
    float sum = -6.0f;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  static constexpr std::uint64_t golden = 0x9e3779b97f4a7c15u;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace fb
