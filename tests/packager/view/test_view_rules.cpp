// What the viewer's web server makes of header fields.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "server/access_token.h"
#include "server/byte_range.h"
#include "server/request_rules.h"

using namespace fb::tool;

namespace {

constexpr int port = 8737;

RequestHead own_request() {
  RequestHead head;
  head.method = "GET";
  head.path = "/";
  head.host = "127.0.0.1:8737";
  return head;
}

int status_with(std::string_view RequestHead::*field, std::string_view value, std::string_view method = "GET") {
  RequestHead head = own_request();
  head.method = method;
  head.*field = value;
  return check_request(head, port).status;
}

bool is(const RangeAnswer& answer, int status, std::size_t first, std::size_t count) {
  return answer.status == status && answer.first == first && answer.count == count;
}

}  // namespace

TEST_CASE("ranges are clipped to the file, refused, or ignored") {
  CHECK(is(answer_range("", 16), 200, 0, 16));
  CHECK(is(answer_range("bytes=0-200000", 16), 206, 0, 16));
  CHECK(is(answer_range("bytes=0-0", 1), 206, 0, 1));
  CHECK(is(answer_range("bytes=15-15", 16), 206, 15, 1));
  CHECK(is(answer_range("bytes=4-", 16), 206, 4, 12));
  CHECK(is(answer_range("bytes=-4", 16), 206, 12, 4));
  CHECK(is(answer_range("bytes=-17", 16), 206, 0, 16));
  CHECK(is(answer_range("bytes=16-", 16), 416, 0, 0));
  CHECK(is(answer_range("bytes=16-20", 16), 416, 0, 0));
  CHECK(is(answer_range("bytes=-0", 16), 416, 0, 0));
  CHECK(is(answer_range("bytes=0-", 0), 416, 0, 0));
  CHECK(is(answer_range("bytes=-5", 0), 416, 0, 0));
  CHECK(is(answer_range("bytes=18446744073709551615-18446744073709551615", 16), 416, 0, 0));
  CHECK(is(answer_range("bytes=1-99999999999999999999999999", 16), 206, 1, 15));
  CHECK(is(answer_range("bytes=18446744073709551617-", 16), 416, 0, 0));  // 2^64 + 1 is not 1
  for (const char* ignored : {"bytes", "bytes=", "bytes=-", "bytes=--1", "bytes=3-2", "bytes=0-1,3-4", "bytes=0 - 1",
                              "bytes=0x1-2", "bytes=+1-2", "items=0-1", "bytes:0-1", "bytes=1", "bytes=a-", "bytes=-b"})
    CHECK_MESSAGE(is(answer_range(ignored, 16), 200, 0, 16), ignored);
}

TEST_CASE("no range reaches beyond a file, whatever its text is") {
  std::mt19937 random(7);
  const std::string letters = "0123456789-=, bytesBYTES";
  for (int round = 0; round < 200000; ++round) {
    std::string text = round % 3 == 0 ? "" : "bytes=";
    for (std::size_t length = random() % 24; length > 0; --length) text += letters[random() % (round % 2 ? 11 : 24)];
    const std::size_t size = round % 5 == 0 ? 0 : random() % 1000;
    const RangeAnswer answer = answer_range(text, size);
    const bool within = answer.first <= size && answer.count <= size - answer.first;
    const bool sensible = answer.status == 206   ? answer.count > 0
                          : answer.status == 200 ? answer.first == 0 && answer.count == size
                                                 : answer.status == 416 && answer.count == 0;
    REQUIRE_MESSAGE((within && sensible), text << " of " << size);
  }
}

TEST_CASE("requests are those of the page itself") {
  CHECK(check_request(own_request(), port).status == 0);
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:8738", "example.org:8737", "localhost", "127.0.0.1:8737.example.org"})
    CHECK_MESSAGE(status_with(&RequestHead::host, host) == 403, host);
  CHECK(status_with(&RequestHead::host, "localhost:8737") == 0);
  RequestHead at_80 = own_request();
  at_80.host = "localhost";
  CHECK(check_request(at_80, 80).status == 0);
  for (const char* origin :
       {"null", "http://example.org", "https://127.0.0.1:8737", "http://127.0.0.1:87370", "127.0.0.1:8737"})
    CHECK_MESSAGE(status_with(&RequestHead::origin, origin) == 403, origin);
  CHECK(status_with(&RequestHead::origin, "http://127.0.0.1:8737", "POST") == 0);
  for (const char* method : {"GET", "HEAD", "POST"}) {
    CHECK(status_with(&RequestHead::fetch_site, "cross-site", method) == 403);
    CHECK(status_with(&RequestHead::fetch_site, "same-site", method) == 403);
    CHECK(status_with(&RequestHead::fetch_site, "same-origin", method) == 0);
    CHECK(status_with(&RequestHead::fetch_site, "none", method) == (method == std::string_view("POST") ? 403 : 0));
  }
  for (const char* method : {"PUT", "OPTIONS", "get", "CONNECT", ""})
    CHECK_MESSAGE(status_with(&RequestHead::range, "", method) == 405, method);
}

TEST_CASE("bodies are plain and say how long they are") {
  CHECK(status_with(&RequestHead::content_encoding, "gzip", "POST") == 415);
  CHECK(status_with(&RequestHead::content_encoding, "Identity", "POST") == 0);
  CHECK(status_with(&RequestHead::transfer_encoding, "chunked", "POST") == 411);
  CHECK(status_with(&RequestHead::content_length, "16777216", "POST") == 0);
  CHECK(status_with(&RequestHead::content_length, "16777217", "POST") == 413);
  CHECK(status_with(&RequestHead::content_length, "36893488147419103233", "POST") == 413);
  CHECK(status_with(&RequestHead::content_length, "0x10", "POST") == 400);
  CHECK(status_with(&RequestHead::content_length, "1", "GET") == 400);
  CHECK(status_with(&RequestHead::content_length, "0", "GET") == 0);
}

TEST_CASE("fields are found whatever their capitals, and may not come twice") {
  RequestHead head = own_request();
  head.take("RANGE", "bytes=0-1");
  head.take("sec-fetch-site", "cross-site");
  head.take("X-Range", "bytes=5-6");
  CHECK(head.range == "bytes=0-1");
  CHECK(check_request(head, port).status == 403);
  head.take("Sec-Fetch-Site", "same-origin");
  CHECK(check_request(head, port).status == 400);
}

TEST_CASE("a token is told by no part of it") {
  const std::string token = make_access_token();
  CHECK(token.size() == 32);
  CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(token != make_access_token());
  CHECK(bears_token("Bearer " + token, token));
  CHECK(bears_token("bearer " + token, token));
  for (std::size_t digit = 0; digit < token.size(); ++digit) {
    std::string wrong = token;
    wrong[digit] = wrong[digit] == '0' ? '1' : '0';
    CHECK_FALSE(bears_token("Bearer " + wrong, token));
    CHECK_FALSE(bears_token("Bearer " + token.substr(0, digit), token));
  }
  for (const std::string& wrong :
       std::vector<std::string>{"", token, "Bearer", "Bearer  " + token, "Bearer " + token + "0"})
    CHECK_FALSE(bears_token(wrong, token));
}
