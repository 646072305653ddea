// Days of the calendar (Gregorian), of UTC, as ISO 8601 writes them: "2031-12-31".
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace fb {

using CalendarDay = std::chrono::sys_days;

// The day that a text is, four digits, two and two; none for any other text, and for a day that no calendar has.
std::optional<CalendarDay> calendar_day_in(std::string_view text);
// The last whole day of what lasts until then: the day itself, or with a time (RFC 3339, "2031-12-31T12:00:00Z" or with
// "+01:00" for Z) the last that ends no later than a second after it. None for any other text.
std::optional<CalendarDay> last_whole_day_in(std::string_view text);
// Of the years 0 to 9999.
std::string calendar_day_text(CalendarDay day);
CalendarDay today();

}  // namespace fb
