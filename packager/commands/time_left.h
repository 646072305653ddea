#pragma once

#include <optional>
#include <string_view>

#include "base/progress.h"

namespace fb::tool {

// How long the rest of a bake takes, in seconds, if its stage, of this phase, takes `stage_left` more
// after `gone` of all: phases to come are taken for the share of the whole that they usually are. Nothing before the
// stage that trains: bakes differ too much in how long what comes then takes.
std::optional<double> seconds_left(Phase phase, std::string_view stage, double stage_left, double gone);

}  // namespace fb::tool
