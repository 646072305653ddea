#include "base/hash.h"

#include <bit>
#include <vector>

#define XXH_INLINE_ALL
#define XXH_NO_XXH3  // which takes vector instructions that not every compiler has

#include <xxhash.h>

namespace fb {

std::uint64_t hash64(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH64(bytes.data(), bytes.size(), seed);
}

std::uint64_t hash64_little(std::span<const float> values, std::uint64_t seed) {
  if constexpr (std::endian::native == std::endian::little) return hash64_of<float>(values, seed);
  std::vector<std::byte> bytes;
  for (const float value : values)
    for (int b = 0; b < 4; ++b) bytes.push_back(static_cast<std::byte>(std::bit_cast<std::uint32_t>(value) >> 8 * b));
  return hash64(bytes, seed);
}

}  // namespace fb
