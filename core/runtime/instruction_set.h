// Selection of kernels by instruction set, once a model, when it is loaded.
#pragma once

#include <vector>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

// The environment variable that caps the instruction set, for tests: the name of a PoseKernels, or empty.
inline constexpr const char* instruction_set_variable = "FB_INSTRUCTION_SET";

// All kernels of this build, from the slowest to the fastest.
std::vector<const PoseKernels*> built_kernels();

// The kernels of this build that this processor supports, from the slowest to the fastest; the first is scalar_kernels.
std::vector<const PoseKernels*> runnable_kernels();

// The fastest supported kernels up to `cap` and the environment's cap. A cap is the name of kernels of this build,
// supported or not; null or "": no cap. Fails with invalid_argument, listing the names, on any other.
const PoseKernels& choose_kernels(const char* cap = nullptr);

}  // namespace fb::runtime
