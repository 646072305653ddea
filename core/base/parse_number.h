// Numbers in text, whatever the locale.
#pragma once

#include <optional>
#include <string_view>

namespace fb {

// The number that the whole of a text is, by the grammar of std::from_chars; T is float, double or long long. For
// floating point: an optional minus sign, digits with at most one point, and an exponent; or "inf" or "nan". Blanks,
// plus signs and hexadecimal digits are no part of it. Nothing if the text is no such number, or one that T cannot
// hold: too large, or so small that only zero is nearer.
template <class T>
std::optional<T> parse_number(std::string_view text);

#ifndef _WIN32
// The same by strtof_l and strtod_l, for C++ libraries whose std::from_chars reads integers only, such as LLVM's before
// version 20. T is float or double.
template <class T>
std::optional<T> parse_number_by_strtod(std::string_view text);
#endif

}  // namespace fb
