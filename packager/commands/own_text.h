#pragma once

#include <string>

namespace fb::tool {

// Prints text of the tool's own, which may have colours and has nothing of others, as it is; otherwise as print_result.
void print_own_text(const std::string& text);

}  // namespace fb::tool
