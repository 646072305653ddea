#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace fb {

// Whether line breaks and tabs are text of ours, or hidden too, as in a name.
enum class Layout { hidden, kept };

// Text from anyone for terminals and messages: what would command a terminal or change the order in which text is read
// becomes visible: control characters, marks of direction and of lines as in JSON, such as "\u001b", and bytes that are
// no UTF-8 as "\xff".
std::string visible_text(std::string_view text, Layout layout);

// Writes as many whole characters of it as there is room for, without a zero, and allocates nothing. Gives their bytes.
std::size_t write_visible_text(std::string_view text, Layout layout, std::span<char> to) noexcept;

}  // namespace fb
