// Floats become whole numbers of one step, so that what is made of them is exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {

// A list of numbers of one pose, or of each pose of a block, side by side: number i of pose p lies at values[i * poses
// + p]. There is room up to the next multiple of padding.
struct PoseNumbers {
  float* values;
  std::size_t count;
  std::uint32_t* places;  // the column number i belongs to
};

// What a layer gives to the next: pose p's numbers lie at values + p * stride, with room as above.
struct PoseRows {
  float* values;
  std::size_t stride, count;
};

// Numbers of 1 or block_poses poses, ready to be multiplied with the columns of a matrix; those of columns not named
// are 0. Refers to where they were put.
struct Quantized {
  const std::uint32_t* places = nullptr;
  const std::int16_t* inputs = nullptr;
  std::size_t count = 0, poses = 1;
  // Of each pose: an input times the step is about the number it stands for; 0 if all numbers are.
  float steps[block_poses] = {};
  std::uint32_t starts[block_poses] = {};

  PanelInputs panel_inputs() const { return {places, inputs, count, poses, starts}; }
};

// FORMAT.md, "Quantise". x's room is filled up, and `quantised` has as much. `limit` is the largest input. Returns
// whether any input is not 0.
bool quantize(const PoseKernels& kernels, const PoseNumbers& x, float limit, std::size_t poses, std::int16_t* quantised,
              Quantized& quantized);

// Does the same with what layers give, of which none is left out.
class LayerInputs {
 public:
  // Of up to `longest` numbers of each of up to `poses` poses.
  LayerInputs(std::size_t longest, std::size_t poses, std::pmr::memory_resource& memory);

  // Where a list may be quantised to.
  std::int16_t* quantised() { return quantised_.data(); }

  // What is returned has no places and is good until the next time.
  const Quantized& quantize(const PoseKernels& kernels, const PoseRows& x, float limit, std::size_t poses);

 private:
  Quantized quantized_;
  std::pmr::vector<std::int16_t> row_, quantised_;
};

}  // namespace fb::runtime
