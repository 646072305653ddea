// Seeded random numbers, independent of the standard library, the thread count and the order of work: every work item
// uses its own stream (seed, stream number).
#pragma once

#include <cstdint>

namespace fb {

class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix(mix(seed) ^ (stream + 1))) {}

  // 64 random bits: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
  std::uint64_t next() { return mix(state_ += golden); }

  // Uniform in [0, 1), 24 bits.
  float uniform() { return static_cast<float>(next() >> 40) * 0x1p-24f; }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }

  // Uniform in [0, count), count > 0; bias below count / 2^32.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(((next() >> 32) * count) >> 32); }

  // Approximately standard normal, in [-6, 6]: the centred sum of 12 uniforms (Irwin-Hall), without libm.
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
