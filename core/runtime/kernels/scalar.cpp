#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// at(k, r): the position of the digit of input k in row r.
template <class At>
void sum_columns(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums,
                 const At& at) {
  for (std::size_t pose = 0; pose < panel.poses; ++pose)
    for (std::size_t r = 0; r < rows; ++r) {
      std::uint32_t sum = panel.initial_sums[pose];
      for (std::size_t k = 0; k < panel.count; ++k) {
        const std::int16_t input = panel.values[(k / 4 * panel.poses + pose) * 4 + k % 4];
        sum += static_cast<std::uint32_t>(input * digits[at(k, r)]);
      }
      sums[max_panel_rows * pose + r] = static_cast<std::int32_t>(sum);
    }
}

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  sum_columns(digits, rows, panel, sums,
              [&](std::size_t k, std::size_t r) { return panel.indices[k] * column_panel_rows + r; });
}

void quad_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  sum_columns(digits, rows, panel, sums, [&](std::size_t k, std::size_t r) {
    return (k / quad_columns * rows + r) * quad_columns + quad_position(k);
  });
}

}  // namespace

const PoseKernels scalar_kernels = make_kernels("scalar", column_sums, quad_sums);

}  // namespace fb::runtime
