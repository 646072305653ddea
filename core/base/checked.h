// Size arithmetic on untrusted numbers: fails with Status::limit instead of wrapping. `what` names the size in the
// message.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/status.h"

namespace fb {

inline std::size_t checked_multiply(std::size_t a, std::size_t b, const char* what) {
  std::size_t product;
  if (__builtin_mul_overflow(a, b, &product)) fail(Status::limit, "%s: %zu x %zu overflows", what, a, b);
  return product;
}

inline std::size_t checked_add(std::size_t a, std::size_t b, const char* what) {
  std::size_t sum;
  if (__builtin_add_overflow(a, b, &sum)) fail(Status::limit, "%s: %zu + %zu overflows", what, a, b);
  return sum;
}

// Narrows a count to 32 bits, the width of counts in archives and in the C ABI.
inline std::uint32_t checked_u32(std::size_t n, const char* what) {
  if (n > UINT32_MAX) fail(Status::limit, "%s: %zu does not fit 32 bits", what, n);
  return static_cast<std::uint32_t>(n);
}

}  // namespace fb
