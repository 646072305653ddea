#pragma once

#include <string>

#include "bench/speed.h"

namespace fb::tool {

// A table with a sentence on whether to believe it, comma-separated values with a line a figure, and JSON, whose keys
// docs/measuring.md has.
std::string speed_text(const Speed& speed);
std::string speed_json(const Speed& speed);
std::string speed_csv(const Speed& speed);

}  // namespace fb::tool
