#pragma once

#include <string>

namespace fb::tool {

// What `facebaker --version` prints: the version, and what the tool and its library were built with.
std::string tool_version();

}  // namespace fb::tool
