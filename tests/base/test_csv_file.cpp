// Tables as spreadsheets and apps save them.
#include <doctest/doctest.h>

#include <string>

#include "base/csv_file.h"
#include "base/file.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb::test_csv_file {
namespace {

// UTF-16 of a text of ASCII letters.
std::string utf16(const std::string& text, bool big, bool mark) {
  std::string bytes = !mark ? "" : big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) {
    if (big) bytes += '\0';
    bytes += c;
    if (!big) bytes += '\0';
  }
  return bytes;
}

std::string message_of(const std::string& bytes) {
  const test::Folder folder;
  write_file(folder / "take.csv", bytes);
  try {
    CsvFile file(folder / "take.csv");
    while (file.next()) file.number(0);
  } catch (const Error& error) {
    CHECK(error.status() == Status::bad_data);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("tables are separated by commas, semicolons or tabs, in UTF-8 or UTF-16") {
  const char* const texts[] = {"jaw,brow\r\n0.5,-1\r\n",    "jaw;brow\r\n0.5;-1\r\n",
                               "jaw;brow\n0,5;-1\n",        "jaw\tbrow\n0,5\t-1",
                               "sep=;\njaw;brow\n0,5;-1\n", "\"jaw\";\"brow\"\n\"0,5\";\"-1\"\n"};
  for (const std::string text : texts)
    for (const std::string& bytes : {text, "\xef\xbb\xbf" + text, utf16(text, false, true), utf16(text, true, true),
                                     utf16(text, false, false), utf16(text, true, false)}) {
      CAPTURE(text);
      CAPTURE(bytes.size());
      const test::Folder folder;
      write_file(folder / "take.csv", bytes);
      CsvFile file(folder / "take.csv");
      CHECK(file.names() == std::vector<std::string>{"jaw", "brow"});
      REQUIRE(file.next());
      CHECK(file.number(0) == 0.5f);
      CHECK(file.number(1) == -1);
      CHECK_FALSE(file.next());
    }
}

TEST_CASE("letters beyond ASCII come out of UTF-16 as they are") {
  const test::Folder folder;
  const std::string bytes("\xff\xfe\xe4\0\xac\x20\x3d\xd8\0\xde,\0b\0\n\0001\0,\0002\0", 22);
  write_file(folder / "take.csv", bytes);
  CHECK(CsvFile(folder / "take.csv").names() == std::vector<std::string>{"\u00e4\u20ac\U0001f600", "b"});
}

TEST_CASE("UTF-16 that is cut off is refused by its byte") {
  CHECK(message_of("\xff\xfe"
                   "a")
            .find("at byte 2") != std::string::npos);
  CHECK(message_of(std::string("\xff\xfe\x3d\xd8", 4)).find("at byte 4") != std::string::npos);
  CHECK(message_of(std::string("\xff\xfe\0\xde", 4)).find("at byte 2") != std::string::npos);
  CHECK(message_of("jaw,brow\n0;5,1\n").find("\"0;5\" is no number") != std::string::npos);
}

}  // namespace fb::test_csv_file
