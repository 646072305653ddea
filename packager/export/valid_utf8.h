#pragma once

#include <string>

namespace fb::tool {

// The text, with bytes that are no UTF-8, which JSON does not hold, replaced.
std::string valid_utf8(const std::string& text);

}  // namespace fb::tool
