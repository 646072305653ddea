#pragma once

#include <string>

#include "bench/speed.h"

namespace fb::tool {

// A table, and comma-separated values with a line a figure.
std::string speed_text(const Speed& speed);
std::string speed_csv(const Speed& speed);

}  // namespace fb::tool
