// Panel sums of kernels for instruction sets that this processor may not have, emulated with SIMDe, on memory that ends
// with the panel.
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "base/random.h"
#include "runtime/kernels/pose_kernels.h"

namespace {

using namespace fb;
using namespace fb::runtime;

bool agree(const PoseKernels& kernels, Random& random, bool quads, std::size_t poses, std::size_t rows,
           std::size_t columns, std::size_t count, bool extreme) {
  const std::size_t bytes = (quads ? rows : column_panel_rows) * columns;
  const auto digits = std::make_unique<std::uint8_t[]>(bytes);
  for (std::size_t i = 0; i < bytes; ++i)
    digits[i] = static_cast<std::uint8_t>(extreme ? 255 * random.below(2) : random.below(256));
  if (quads) count = columns;
  std::vector<std::uint32_t> indices, initial_sums(poses);
  for (std::size_t i = 0; i < count; ++i) indices.push_back(random.below(static_cast<std::uint32_t>(columns)));
  std::vector<std::int16_t> values;
  for (std::size_t i = 0; i < count * poses; ++i) {
    const int any = int(random.below(65025)) - 32512;
    values.push_back(static_cast<std::int16_t>(extreme ? (any < 0 ? -32512 : 32512) : any));
    initial_sums[i / 4 % poses] -= 128 * static_cast<std::uint32_t>(values.back());
  }
  const PanelInputs inputs = {indices.data(), values.data(), count, poses, initial_sums.data()};
  std::int32_t expected[poses_per_block * max_panel_rows] = {}, found[poses_per_block * max_panel_rows] = {};
  const auto sum = [&](const PoseKernels& with, std::int32_t* sums) {
    (quads ? with.quad_sums : with.column_sums)(digits.get(), rows, inputs, sums);
  };
  sum(scalar_kernels, expected);
  sum(kernels, found);
  for (std::size_t pose = 0; pose < poses; ++pose)
    if (std::memcmp(expected + max_panel_rows * pose, found + max_panel_rows * pose, rows * sizeof(std::int32_t)) != 0)
      return false;
  return true;
}

}  // namespace

int main() {
  Random random(3);
  int wrong = 0, all = 0;
  for (const PoseKernels* kernels : {&avx_vnni_kernels, &avx512_vnni_kernels})
    for (const bool quads : {false, true})
      for (const std::size_t poses : {std::size_t{1}, poses_per_block})
        for (std::size_t rows = 16; rows <= (quads ? quad_panel_rows : max_panel_rows); rows += 16)
          for (const std::size_t columns : {4, 40})
            for (const std::size_t count : {0, 4, 8, 60})
              for (const bool extreme : {false, true}) {
                ++all;
                if (agree(*kernels, random, quads, poses, rows, columns, count, extreme)) continue;
                ++wrong;
                std::printf("%s, %s: %zu poses, %zu x %zu, %zu columns\n", kernels->name, quads ? "quads" : "columns",
                            poses, rows, columns, count);
              }
  std::printf("%d of %d wrong\n", wrong, all);
  return wrong == 0 ? 0 : 1;
}
