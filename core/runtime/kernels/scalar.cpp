#include "runtime/kernels/panel_kernels.h"

namespace fb {
namespace {

#include "runtime/kernels/vector_passes.h"

void panel_sums(const std::uint8_t* digits, std::size_t rows, const ActiveColumns& active, std::int32_t* sums) {
  for (std::size_t pose = 0; pose < active.poses; ++pose)
    for (std::size_t r = 0; r < rows; ++r) {
      std::uint32_t sum = active.start[pose];
      for (std::size_t k = 0; k < active.count; ++k) {
        const std::int16_t input = active.inputs[(k / 4 * active.poses + pose) * 4 + k % 4];
        sum += static_cast<std::uint32_t>(input * digits[active.places[k] * rows + r]);
      }
      sums[panel_rows * pose + r] = static_cast<std::int32_t>(sum);
    }
}

}  // namespace

const PoseKernels scalar_kernels = {"scalar",  panel_sums,   round_all, round_block,
                                    move_rows, finish_layer, to_halves, normalise};

}  // namespace fb
