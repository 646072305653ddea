#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/vector_passes.h"

// `at(k, r)`: where the digit of input k and row r lies.
template <class At>
void add_up(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums, const At& at) {
  for (std::size_t pose = 0; pose < panel.poses; ++pose)
    for (std::size_t r = 0; r < rows; ++r) {
      std::uint32_t sum = panel.start[pose];
      for (std::size_t k = 0; k < panel.count; ++k) {
        const std::int16_t input = panel.inputs[(k / 4 * panel.poses + pose) * 4 + k % 4];
        sum += static_cast<std::uint32_t>(input * digits[at(k, r)]);
      }
      sums[most_rows * pose + r] = static_cast<std::int32_t>(sum);
    }
}

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  add_up(digits, rows, panel, sums, [&](std::size_t k, std::size_t r) { return panel.places[k] * column_rows + r; });
}

void quad_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  add_up(digits, rows, panel, sums,
         [&](std::size_t k, std::size_t r) { return (k / quad_columns * rows + r) * quad_columns + place_in_quad(k); });
}

}  // namespace

const PoseKernels scalar_kernels = with_passes("scalar", column_sums, quad_sums);

}  // namespace fb::runtime
