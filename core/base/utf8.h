#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace fb {

// The first byte at which a text is not UTF-8 (RFC 3629: shortest forms, no surrogates, up to U+10FFFF) or is zero.
std::optional<std::size_t> find_utf8_fault(std::string_view text);

}  // namespace fb
