// Panel products of kernels for instruction sets that this processor may not have, emulated with SIMDe, on memory that
// ends with the panel.
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "base/random.h"
#include "runtime/kernels/pose_kernels.h"

namespace {

using namespace fb;
using namespace fb::runtime;

// The digits of `lines` columns or quads as the kernels store them.
std::unique_ptr<std::uint8_t[]> stored_for(const PoseKernels& kernels, const std::vector<std::uint8_t>& digits,
                                           bool quads) {
  auto stored = std::make_unique<std::uint8_t[]>(digits.size());
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const std::size_t to = quads ? i : i / column_group * column_group + kernels.column_rows[i % column_group];
    stored[to] = static_cast<std::uint8_t>(digits[i] + (!quads && kernels.signed_odd_digits && to % 2 != 0 ? 128 : 0));
  }
  return stored;
}

bool agree(const PoseKernels& kernels, Random& random, bool quads, std::size_t poses, std::size_t rows,
           std::size_t columns, std::size_t count, bool extreme) {
  const std::size_t column = (rows + column_group - 1) / column_group * column_group;
  const std::size_t quad_rows = (rows + quad_group - 1) / quad_group * quad_group;
  std::vector<std::uint8_t> digits((quads ? quad_rows : column) * columns);
  for (std::uint8_t& digit : digits)
    digit = static_cast<std::uint8_t>(extreme ? 255 * random.below(2) : random.below(256));
  if (quads) count = columns;
  std::vector<std::uint32_t> offsets, initial_sums(poses);
  for (std::size_t i = 0; i < count; ++i)
    offsets.push_back(static_cast<std::uint32_t>(column) * random.below(static_cast<std::uint32_t>(columns)));
  std::vector<std::int16_t> values;
  for (std::size_t i = 0; i < count * poses; ++i) {
    const int any = int(random.below(65025)) - 32512;
    values.push_back(static_cast<std::int16_t>(extreme ? (any < 0 ? -32512 : 32512) : any));
    initial_sums[i / 4 % poses] -= 128 * static_cast<std::uint32_t>(values.back());
  }
  const PanelInputs inputs = {offsets.data(), values.data(), count, poses, initial_sums.data()};
  const std::vector<float> bias(rows + padding), steps(poses, 1);
  const auto multiply = [&](const PoseKernels& with) {
    std::vector<float> found(poses * rows);
    float* to[poses_per_block];
    for (std::size_t pose = 0; pose < poses; ++pose) to[pose] = found.data() + pose * rows;
    const auto stored = stored_for(with, digits, quads);
    (quads ? with.quad_product : with.column_product)({stored.get(), rows, quad_columns * quad_rows}, inputs,
                                                      {nullptr, bias.data(), steps.data(), to});
    return found;
  };
  return multiply(scalar_kernels) == multiply(kernels);
}

}  // namespace

int main() {
  Random random(3);
  int wrong = 0, all = 0;
  for (const PoseKernels* kernels : {&avx_vnni_kernels, &avx512_vnni_kernels})
    for (const bool quads : {false, true})
      for (const std::size_t poses : {std::size_t{1}, poses_per_block})
        for (std::size_t rows = 8; rows <= (quads ? quad_panel_rows : max_panel_rows); rows += 8)
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
