// Kernels for processors this one may not be, through SIMDe: their sums, in memory that ends where a panel does.
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "base/random.h"
#include "runtime/kernels/panel_kernels.h"

namespace {

using namespace fb;

bool agree(const PoseKernels& kernels, Random& random, std::size_t poses, std::size_t rows, std::size_t columns,
           std::size_t count, bool extreme) {
  const auto digits = std::make_unique<std::uint8_t[]>(rows * columns);
  for (std::size_t i = 0; i < rows * columns; ++i)
    digits[i] = static_cast<std::uint8_t>(extreme ? 255 * random.below(2) : random.below(256));
  std::vector<std::uint32_t> places, starts(poses);
  for (std::size_t i = 0; i < count; ++i) places.push_back(random.below(static_cast<std::uint32_t>(columns)));
  std::vector<std::int16_t> inputs;
  for (std::size_t i = 0; i < count * poses; ++i) {
    const int any = int(random.below(65025)) - 32512;
    inputs.push_back(static_cast<std::int16_t>(extreme ? (any < 0 ? -32512 : 32512) : any));
    starts[i / 4 % poses] -= 128 * static_cast<std::uint32_t>(inputs.back());
  }
  const ActiveColumns active = {places.data(), inputs.data(), count, poses, starts.data()};
  std::int32_t expected[block_poses * panel_rows] = {}, found[block_poses * panel_rows] = {};
  scalar_kernels.panel_sums(digits.get(), rows, active, expected);
  kernels.panel_sums(digits.get(), rows, active, found);
  return std::memcmp(expected, found, sizeof expected) == 0;
}

}  // namespace

int main() {
  Random random(3);
  int wrong = 0, all = 0;
  for (const PoseKernels* kernels : {&avx_vnni_kernels, &avx512_vnni_kernels})
    for (const std::size_t poses : {std::size_t{1}, block_poses})
      for (const std::size_t rows : {16, 32, 48, 64})
        for (const std::size_t columns : {1, 3, 40})
          for (const std::size_t count : {0, 4, 8, 60})
            for (const bool extreme : {false, true}) {
              ++all;
              if (agree(*kernels, random, poses, rows, columns, count, extreme)) continue;
              ++wrong;
              std::printf("%s: %zu poses, %zu x %zu, %zu columns\n", kernels->name, poses, rows, columns, count);
            }
  std::printf("%d of %d wrong\n", wrong, all);
  return wrong == 0 ? 0 : 1;
}
