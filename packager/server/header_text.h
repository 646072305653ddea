// Pieces of header values, as HTTP writes them.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace fb::tool {

// Whether two ASCII texts are the same, capitals or not.
bool same_without_case(std::string_view a, std::string_view b);

// Decimal digits and nothing else, at least one; what does not fit is SIZE_MAX.
std::optional<std::size_t> decimal(std::string_view text);

}  // namespace fb::tool
