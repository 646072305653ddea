// Days of the calendar, and moments by their day of UTC.
#include "base/calendar_day.h"

#include <doctest/doctest.h>

namespace test_calendar_day {

using namespace fb;

namespace {

std::string last_day(const char* text) {
  const auto day = last_whole_day_in(text);
  return day ? calendar_day_text(*day) : "none";
}

}  // namespace

TEST_CASE("a day is what the calendar has") {
  for (const char* text : {"2031-12-31", "1970-01-01", "0000-01-01", "9999-12-31", "2024-02-29", "2000-02-29"}) {
    REQUIRE(calendar_day_in(text));
    CHECK(calendar_day_text(*calendar_day_in(text)) == text);
  }
  CHECK(*calendar_day_in("1970-01-02") - *calendar_day_in("1970-01-01") == std::chrono::days(1));
  CHECK(*calendar_day_in("2025-03-01") - *calendar_day_in("2025-02-28") == std::chrono::days(1));
  CHECK(*calendar_day_in("2024-03-01") - *calendar_day_in("2024-02-28") == std::chrono::days(2));
}

TEST_CASE("what is no day is none") {
  for (const char* text :
       {"", "2031", "2031-12", "2031-12-3", "2031-12-311", "31-12-2031", "2031/12/31", "2031-13-01", "2031-00-01",
        "2031-01-00", "2031-04-31", "2023-02-29", "2100-02-29", "+031-12-31", "2031-1 -01", " 2031-12-31", "soon"})
    CHECK_MESSAGE(!calendar_day_in(text), text);
}

TEST_CASE("a moment counts to the last whole day of UTC before it") {
  CHECK(last_day("2031-12-31") == "2031-12-31");
  CHECK(last_day("2031-12-31T23:59:59Z") == "2031-12-31");
  CHECK(last_day("2031-12-31T23:59:60Z") == "2031-12-31");
  CHECK(last_day("2031-12-31T23:59:59.999Z") == "2031-12-31");
  CHECK(last_day("2032-01-01T00:00:00Z") == "2031-12-31");
  CHECK(last_day("2031-12-31T23:59:58Z") == "2031-12-30");
  CHECK(last_day("2024-03-01T12:00:00Z") == "2024-02-29");
  CHECK(last_day("2032-01-01T00:59:59+01:00") == "2031-12-31");
  CHECK(last_day("2031-12-31T23:59:59+01:00") == "2031-12-30");
  CHECK(last_day("2031-12-31t19:59:59-04:00") == "2031-12-31");
  for (const char* text :
       {"2031-12-31T23:59:59", "2031-12-31T23:59Z", "2031-12-31 23:59:59Z", "2031-12-31T24:00:00Z",
        "2031-12-31T23:60:00Z", "2031-12-31T23:59:61Z", "2031-12-31T23:59:59.Z", "2031-12-31T23:59:59+0100",
        "2031-12-31T23:59:59+24:00", "2031-12-31T", "2031-02-30T00:00:00Z", "2031-12-31T23:59:59Z ", "spring 2031"})
    CHECK_MESSAGE(last_day(text) == "none", text);
}

TEST_CASE("today is a day between this test's writing and the end of four digits") {
  CHECK(today() >= *calendar_day_in("2025-01-01"));
  CHECK(today() < *calendar_day_in("9999-12-31"));
}

}  // namespace test_calendar_day
