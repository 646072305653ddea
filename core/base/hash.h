#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fb {

// XXH64 (https://xxhash.com, doc/xxhash_spec.md): the checksum of archives and of sampling plans.
std::uint64_t hash64(std::span<const std::byte> bytes, std::uint64_t seed = 0);

// Of the values' bytes in memory.
template <class T>
std::uint64_t hash64_of(std::span<const T> values, std::uint64_t seed = 0) {
  return hash64(std::as_bytes(values), seed);
}

// Of the floats as little-endian bytes on every machine.
std::uint64_t hash64_little(std::span<const float> values, std::uint64_t seed = 0);

}  // namespace fb
