#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fb {

// XXH64 of the bytes (https://xxhash.com, specification doc/xxhash_spec.md): the checksum of archives and of plans.
std::uint64_t hash64(std::span<const std::byte> bytes, std::uint64_t seed = 0);

template <class T>
std::uint64_t hash64_of(std::span<const T> values, std::uint64_t seed = 0) {
  return hash64(std::as_bytes(values), seed);
}

// Of floats as little-endian bytes, whatever the machine.
std::uint64_t hash64_little(std::span<const float> values, std::uint64_t seed = 0);

}  // namespace fb
