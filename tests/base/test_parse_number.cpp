// Numbers in text: both ways of reading them give the same, in any locale.
#include <doctest/doctest.h>

#include <bit>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "base/parse_number.h"
#include "base/random.h"

namespace fb::test_parse_number {
namespace {

// NaN for what is no number: texts that say "nan" are tested apart.
template <class T>
void check_both(const std::string& text, double expected) {
  CAPTURE(text);
  for (const std::optional<T>& found : {parse_number<T>(text), parse_number_by_strtod<T>(text)}) {
    CHECK(found.has_value() == !std::isnan(expected));
    if (found) CHECK(double(*found) == expected);
    if (found && expected == 0) CHECK(std::signbit(*found) == std::signbit(expected));
  }
}

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

void check_texts() {
  for (const auto& [text, expected] : {std::pair{"1", 1.0},
                                       {"-1", -1},
                                       {"007", 7},
                                       {".5", 0.5},
                                       {"5.", 5},
                                       {"-.125e1", -1.25},
                                       {"2E+3", 2000},
                                       {"0e9999999999", 0},
                                       {"-0.000", -0.0},
                                       {"inf", infinite},
                                       {"-INFINITY", -infinite},
                                       {"1e39x", none},
                                       {"1e400", none},
                                       {"-1e400", none},
                                       {"1e-400", none},
                                       {"", none},
                                       {"-", none},
                                       {".", none},
                                       {"+1", none},
                                       {"-+1", none},
                                       {"--1", none},
                                       {" 1", none},
                                       {"- 1", none},
                                       {"1 ", none},
                                       {"\t1", none},
                                       {"1\n", none},
                                       {"1,5", none},
                                       {"1.5.", none},
                                       {"1e", none},
                                       {"1e+", none},
                                       {"e5", none},
                                       {"0x10", none},
                                       {"-0X1p3", none},
                                       {"1f", none},
                                       {"1'000", none},
                                       {"infinit", none},
                                       {"none", none}}) {
    check_both<float>(text, expected);
    check_both<double>(text, expected);
  }
}

}  // namespace

TEST_CASE("numbers are read by one grammar, both ways") {
  check_texts();
  check_both<double>(std::string("1\0", 2), none);
  check_both<double>(std::string("1\0002", 3), none);
}

TEST_CASE("numbers are read to the end of the range, both ways") {
  check_both<float>("3.4028235e38", std::numeric_limits<float>::max());
  check_both<float>("3.4028236e38", none);
  check_both<float>("1.17549435e-38", std::numeric_limits<float>::min());
  check_both<float>("1e-45", std::numeric_limits<float>::denorm_min());
  check_both<float>("1e-46", none);
  check_both<float>("-1e-46", none);
  check_both<double>("1.7976931348623157e308", std::numeric_limits<double>::max());
  check_both<double>("5e-324", std::numeric_limits<double>::denorm_min());
  check_both<double>("1e-324", none);
  for (const char* const text : {"nan", "NaN", "-nan", "nan(12)"}) {
    CAPTURE(text);
    CHECK(std::isnan(parse_number<float>(text).value_or(0)));
    CHECK(std::isnan(parse_number_by_strtod<float>(text).value_or(0)));
  }
}

TEST_CASE("every float reads as it is written, both ways") {
  Random random(7);
  for (int i = 0; i < 20000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random.next()));
    if (!std::isfinite(value)) continue;
    char digits[64];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    const std::string text(digits, end);
    REQUIRE(parse_number<float>(text) == value);
    REQUIRE(parse_number_by_strtod<float>(text) == value);
    REQUIRE(parse_number<double>(text) == parse_number_by_strtod<double>(text));
  }
}

TEST_CASE("a decimal comma of the locale is none of theirs") {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  bool found = false;
  for (const char* const name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE", "fr_FR"})
    found = found || std::setlocale(LC_NUMERIC, name);
  if (!found) MESSAGE("skipped: no locale with a decimal comma is installed");
  if (found) check_texts();
  std::setlocale(LC_NUMERIC, before.c_str());
}

TEST_CASE("whole numbers") {
  CHECK(parse_number<long long>("-12") == -12);
  CHECK(parse_number<long long>("9223372036854775807") == std::numeric_limits<long long>::max());
  for (const char* const text : {"", "-", "+1", " 1", "1 ", "1.0", "0x1", "9223372036854775808"}) {
    CAPTURE(text);
    CHECK(!parse_number<long long>(text));
  }
}

}  // namespace fb::test_parse_number
