// Which kernels run: chosen once a model, when it is loaded.
#pragma once

#include <vector>

#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {

// The environment variable that caps them, for tests: the name of a PoseKernels, or empty.
inline constexpr const char* instruction_set_variable = "FB_INSTRUCTION_SET";

// Those of this build that this processor can run, from the slowest to the fastest; the first is scalar_kernels.
std::vector<const PoseKernels*> runnable_kernels();

// The fastest that are not beyond `cap`, nor beyond what the environment says. A cap is the name of kernels this build
// has, runnable or not; null or "": no cap. Fails with invalid_argument, listing the names, on any other.
const PoseKernels& choose_kernels(const char* cap = nullptr);

}  // namespace fb::runtime
