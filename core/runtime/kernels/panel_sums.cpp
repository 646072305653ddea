#include "runtime/kernels/panel_sums.h"

#include <algorithm>

namespace fb {
namespace {

// Two columns a pass, because with one the sums would be loaded and stored for every product. The number of rows is
// known when compiling and products are of 16-bit numbers, which is what compilers make wide multiplications of.
template <std::size_t rows>
void add_up(const std::int8_t* digits, std::span<const ActiveColumn> active, std::int32_t* sums) {
  std::size_t k = 0;
  for (; k + 2 <= active.size(); k += 2) {
    const std::int8_t* a = digits + active[k].place * rows;
    const std::int8_t* b = digits + active[k + 1].place * rows;
    const auto x = static_cast<std::int16_t>(active[k].input), y = static_cast<std::int16_t>(active[k + 1].input);
    for (std::size_t r = 0; r < rows; ++r)
      sums[r] += std::int32_t(std::int16_t(a[r])) * x + std::int32_t(std::int16_t(b[r])) * y;
  }
  if (k < active.size()) {
    const std::int8_t* a = digits + active[k].place * rows;
    const auto x = static_cast<std::int16_t>(active[k].input);
    for (std::size_t r = 0; r < rows; ++r) sums[r] += std::int32_t(std::int16_t(a[r])) * x;
  }
}

}  // namespace

void panel_sums(const std::int8_t* digits, std::size_t rows, std::span<const ActiveColumn> active, std::int32_t* sums) {
  std::fill_n(sums, rows, 0);
  switch (rows) {
    case 16:
      return add_up<16>(digits, active, sums);
    case 32:
      return add_up<32>(digits, active, sums);
    case 48:
      return add_up<48>(digits, active, sums);
    default:
      return add_up<64>(digits, active, sums);
  }
}

}  // namespace fb
