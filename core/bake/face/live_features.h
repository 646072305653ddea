#pragma once

#include "model/network.h"

namespace fb {

// Takes the features out of a network that no coefficient, input, gate or other feature needs; the others keep their
// order.
void keep_used_features(Network& network);

}  // namespace fb
