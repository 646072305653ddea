#include "base/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace fb {

std::uint64_t hash64(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH64(bytes.data(), bytes.size(), seed);
}

}  // namespace fb
