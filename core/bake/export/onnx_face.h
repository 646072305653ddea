#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "model/packed_model.h"

namespace fb::bake {

// What is written beside the graph.
struct OnnxTexts {
  std::string licence;
  std::string producer_version;
};

// What an ONNX file of a face has.
struct OnnxFace {
  // parameters: floats of weights, biases, basis, corrections, and weights of vertices that follow joints
  std::uint64_t nodes = 0, parameters = 0;
};

// Writes what a face evaluates to (core/archive/EVALUATION.md, at level of detail 0) as an ONNX model of operator set
// 13, complete or not at all:
//   input   "controls"   float32 [n, controls], clamped to their ranges inside
//   output  "positions"  float32 [n, vertices, 3], in the face's units and vertex order
//   output  "channels"   float32 [n, channels], only where the face has some
//   output  "joints"     float32 [n, driven joints, 3, 4], their frames, only where the face has some
// Weights are the archive's quantised ones, in floats; inputs of layers and of the basis are rounded as EVALUATION.md
// says, and sums of whole numbers exact. Normals, sockets and expected errors are left out. The names, ranges
// and rest values of the controls, names of channels and joints, units, axis and licence are among the model's
// properties. Fails with limit beyond 2
// GB.
OnnxFace write_onnx(const std::filesystem::path& path, const PackedModel& model, const OnnxTexts& texts);

}  // namespace fb::bake
