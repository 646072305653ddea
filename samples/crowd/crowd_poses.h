// Poses of a crowd that depend on nothing but their number, and checksums of what comes of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace crowd {

// SplitMix64: a hash of a number.
inline std::uint64_t hash(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

// Pose number `pose` of the crowd: a fifth of the controls at random values in their ranges. `controls`: fb_control of
// each; `values`: as many floats.
template <class Controls>
void make_pose(const Controls& controls, std::uint64_t pose, float* values) {
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const std::uint64_t bits = hash(pose * controls.size() + c);
    const float uniform = static_cast<float>(bits >> 40) * 0x1p-24f;
    values[c] =
        bits % 5 == 0 ? controls[c].minimum + (controls[c].maximum - controls[c].minimum) * uniform : controls[c].rest;
  }
}

// A hash of all bits of `count` floats that belong to pose number `pose`.
inline std::uint64_t checksum(std::uint64_t pose, const float* numbers, std::size_t count) {
  std::uint64_t sum = hash(pose);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t bits;
    std::memcpy(&bits, numbers + i, sizeof bits);
    sum = hash(sum ^ bits);
  }
  return sum;
}

}  // namespace crowd
