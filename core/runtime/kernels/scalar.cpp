#if defined(__AVX__)  // a compiler that is told of more than it needs: float_kernels.h uses it
#include <immintrin.h>
#endif

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {
namespace {

#include "runtime/kernels/float_kernels.h"

// at(k, r): the position of the digit of input k in row r.
template <class At>
void product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output, const At& at) {
  for (std::size_t pose = 0; pose < inputs.poses; ++pose)
    for (std::size_t first = 0; first < panel.rows; first += 16) {
      std::int32_t sums[16] = {};
      for (std::size_t r = 0; r < 16 && first + r < panel.rows; ++r) {
        std::uint32_t sum = inputs.initial_sums[pose];
        for (std::size_t k = 0; k < inputs.count; ++k) {
          const std::int16_t input = inputs.values[(k / 4 * inputs.poses + pose) * 4 + k % 4];
          sum += static_cast<std::uint32_t>(input * panel.digits[at(k, first + r)]);
        }
        sums[r] = static_cast<std::int32_t>(sum);
      }
      finish_rows(panel, output, pose, first, 16, sums);
    }
}

void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  product(panel, inputs, output, [&](std::size_t k, std::size_t r) { return inputs.offsets[k] + r; });
}

void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  product(panel, inputs, output, [&](std::size_t k, std::size_t r) {
    return k / quad_columns * panel.stride + quad_columns * r + quad_position(k);
  });
}

}  // namespace

const PoseKernels scalar_kernels = make_kernels("scalar", column_product, quad_product);

}  // namespace fb::runtime
