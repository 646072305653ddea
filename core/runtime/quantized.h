// Floats become whole numbers of one step, so that what is made of them is exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/panel_kernels.h"

namespace fb {

// Up to `longest` numbers, ready to be multiplied with the columns of a matrix.
class Quantized {
 public:
  Quantized(std::size_t longest, std::pmr::memory_resource& memory)
      : wholes_(longest + padding, &memory), places_(longest + padding, &memory), inputs_(longest + padding, &memory) {}

  // FORMAT.md, "Whole numbers", of x[i] at column places[i], or at column i where places is null; columns not named are
  // 0. `limit` is the largest input. x has room up to the next multiple of padding, which is filled with zeros.
  void quantize(const PoseKernels& kernels, float* x, const std::uint32_t* places, std::size_t count, float limit);

  // An input times step() is about the number it stands for; 0 if all numbers are.
  float step() const { return step_; }
  const ActiveColumns& columns() const { return columns_; }

 private:
  std::pmr::vector<std::int32_t> wholes_;
  std::pmr::vector<std::uint32_t> places_;
  std::pmr::vector<std::int16_t> inputs_;
  ActiveColumns columns_ = {};
  float step_ = 0;
};

}  // namespace fb
