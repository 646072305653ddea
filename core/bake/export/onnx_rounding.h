// Products of matrices of digits with rounded inputs (core/archive/EVALUATION.md, "Quantised values"), in a graph of
// floats that gives the evaluator's bits: whole numbers below 2^24 are exact in floats, in whatever order they are
// added. Without rounding, poses that move a vertex far by many controls differ by up to 2e-4 of the diagonal; rounded,
// but with sums that are not exact, by up to 1e-5, where one input is rounded the other way.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "bake/export/onnx_graph.h"
#include "model/packed_model.h"

namespace fb::bake {

// The largest number that inputs are rounded to, of a matrix whose sums of |digits| are at most this.
float rounding_limit(std::uint64_t largest_sum);

// Inputs [n, width] as (256 * high + low) * step, where step [n, 1] is the largest |input| of a row over the limit.
struct RoundedInputs {
  std::string high, low, step;
};
RoundedInputs round_inputs(OnnxGraph& graph, const std::string& label, const std::string& inputs, float limit);

// Sums [n, outputs] of (256 * high + low) times digits, a matrix inputs x outputs of whole numbers up to 128: exact,
// and then rounded to floats, for up to 1,024 inputs.
std::string digit_sums(OnnxGraph& graph, const std::string& label, const RoundedInputs& inputs,
                       std::span<const float> digits, std::size_t outputs);

}  // namespace fb::bake
