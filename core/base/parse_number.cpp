#include "base/parse_number.h"

#include <charconv>
#include <concepts>
#include <system_error>

#ifndef _WIN32
#include <locale.h>
#include <stdlib.h>
#ifdef __APPLE__
#include <xlocale.h>
#endif

#include <cmath>
#include <string>
#endif

namespace fb {
namespace {

template <class T>
std::optional<T> parse_by_from_chars(std::string_view text) {
  const char* const end = text.data() + text.size();
  T value{};
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

}  // namespace

#ifndef _WIN32
template <class T>
std::optional<T> parse_number_by_strtod(std::string_view text) {
  static const locale_t plain = ::newlocale(LC_ALL_MASK, "C", nullptr);
  // What strtod takes besides: blanks, plus signs, hexadecimal digits.
  const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
  if (digits.empty() || digits.find_first_of(" \t\n\v\f\r+") == 0 || digits.starts_with("0x") ||
      digits.starts_with("0X"))
    return std::nullopt;
  const std::string copy(text);  // ends with a zero
  char* stopped = nullptr;
  T value;
  if constexpr (std::same_as<T, float>)
    value = ::strtof_l(copy.c_str(), &stopped, plain);
  else
    value = ::strtod_l(copy.c_str(), &stopped, plain);
  if (stopped != copy.c_str() + copy.size()) return std::nullopt;
  // Beyond the range it gives zero or infinity, which the text does not say.
  const bool says_zero = digits.substr(0, digits.find_first_of("eE")).find_first_of("123456789") == digits.npos;
  if ((value == 0 && !says_zero) || (std::isinf(value) && digits.find_first_of("iI") == digits.npos))
    return std::nullopt;
  return value;
}
template std::optional<float> parse_number_by_strtod(std::string_view text);
template std::optional<double> parse_number_by_strtod(std::string_view text);
#endif

template <class T>
std::optional<T> parse_number(std::string_view text) {
#if !defined(__cpp_lib_to_chars) && !defined(_WIN32)
  if constexpr (std::floating_point<T>)
    return parse_number_by_strtod<T>(text);
  else
#endif
    return parse_by_from_chars<T>(text);
}
template std::optional<float> parse_number(std::string_view text);
template std::optional<double> parse_number(std::string_view text);
template std::optional<long long> parse_number(std::string_view text);

}  // namespace fb
