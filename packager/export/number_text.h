#pragma once

#include <charconv>
#include <string>

namespace fb::tool {

// Appends the shortest digits that give the same number.
template <class Number>
void append_number(std::string& text, Number number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  text.append(digits, end);
}

}  // namespace fb::tool
