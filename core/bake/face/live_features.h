#pragma once

#include "model/network.h"

namespace fb::bake {

// Takes the features out of a network that no coefficient, input, gate or other feature needs; the others keep their
// order.
void keep_live_features(Network& network);

}  // namespace fb::bake
