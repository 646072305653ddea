#include "base/calendar_day.h"

#include <algorithm>

#include "base/status.h"

namespace fb {
namespace {

using std::chrono::days;
using std::chrono::seconds;

// The number that all of `text` is, in decimal digits; -1 for any other text.
int digits_in(std::string_view text) {
  int number = 0;
  for (const char digit : text) {
    if (digit < '0' || digit > '9') return -1;
    number = 10 * number + (digit - '0');
  }
  return number;
}

// "hh:mm", with `most` hours.
std::optional<seconds> minutes_in(std::string_view text, int most) {
  if (text.size() != 5 || text[2] != ':') return std::nullopt;
  const int hours = digits_in(text.substr(0, 2)), minutes = digits_in(text.substr(3));
  if (hours < 0 || hours > most || minutes < 0 || minutes > 59) return std::nullopt;
  return std::chrono::hours(hours) + std::chrono::minutes(minutes);
}

// What a local time is ahead of UTC: "Z", "+01:00".
std::optional<seconds> offset_in(std::string_view text) {
  if (text == "Z" || text == "z") return seconds(0);
  if (text.empty() || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const std::optional<seconds> size = minutes_in(text.substr(1), 23);
  return size && text[0] == '-' ? -*size : size;
}

// Of a day, less the offset: "12:00:00Z", "12:00:00.25+01:00". Parts of a second are dropped; a leap second is one.
std::optional<seconds> time_in(std::string_view text) {
  if (text.size() < 9 || text[5] != ':') return std::nullopt;
  const std::optional<seconds> minutes = minutes_in(text.substr(0, 5), 23);
  const int second = digits_in(text.substr(6, 2));
  std::string_view rest = text.substr(8);
  if (rest[0] == '.') {
    const std::size_t end = std::min(rest.find_first_not_of("0123456789", 1), rest.size());
    if (end == 1) return std::nullopt;
    rest.remove_prefix(end);
  }
  const std::optional<seconds> offset = offset_in(rest);
  if (!minutes || second < 0 || second > 60 || !offset) return std::nullopt;
  return *minutes + seconds(second) - *offset;
}

}  // namespace

std::optional<CalendarDay> calendar_day_in(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const int year = digits_in(text.substr(0, 4)), month = digits_in(text.substr(5, 2)), day = digits_in(text.substr(8));
  if (year < 0 || month < 0 || day < 0) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year{year}, std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok()) return std::nullopt;
  return CalendarDay(date);
}

std::optional<CalendarDay> last_whole_day_in(std::string_view text) {
  const std::optional<CalendarDay> day = calendar_day_in(text.substr(0, 10));
  if (!day || text.size() == 10) return day;
  if (text[10] != 'T' && text[10] != 't') return std::nullopt;
  const std::optional<seconds> time = time_in(text.substr(11));
  if (!time) return std::nullopt;
  return std::chrono::floor<days>(*day + *time + seconds(1)) - days(1);
}

std::string calendar_day_text(CalendarDay day) {
  const std::chrono::year_month_day date(day);
  return format("%04d-%02u-%02u", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()));
}

CalendarDay today() {
  return std::chrono::floor<days>(std::chrono::system_clock::now());
}

}  // namespace fb
