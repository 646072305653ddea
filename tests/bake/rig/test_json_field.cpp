// The reader of JSON from anyone: what it gives, and how it names what is wrong.
#include "bake/rig/json_field.h"

#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "bake_test_support.h"

namespace test_json_field {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::array<std::string_view, 2> words = {"left", "right"};

TEST_CASE("fields are read by type, and those that are missing as what is given instead") {
  const json text =
      parse_json<json>(R"({"a": [{"n": 4294967295, "x": -0.5, "s": "", "t": true, "w": "right", "h": "00ff"}],
                                   "v": [1, 2.5]})",
                       "text");
  const JsonField root(text, "text:"), a = root["a"].nonempty_items().at(0);
  CHECK(a["n"].count() == UINT32_MAX);
  CHECK(a["x"].number() == -0.5);
  CHECK(a["x"].single_or(1) == -0.5f);
  CHECK(a["s"].text() == "");
  CHECK(a["t"].flag_or(false));
  CHECK(a["w"].word_or(0, words) == 1);
  CHECK(a["h"].hash() == 255);
  CHECK(root["v"].singles() == std::vector<float>{1, 2.5f});
  const JsonField none = a["none"];
  CHECK_FALSE(none.exists());
  CHECK(none.items_or_none().empty());
  CHECK(none.text_or("other") == "other");
  CHECK(none.single_or(2) == 2);
  CHECK(none.count_or(7) == 7);
  CHECK(none.flag_or(true));
  CHECK(none.word_or(1, words) == 1);
  std::array<float, 2> values = {3, 4};
  none.read_singles(values);
  CHECK(values == std::array<float, 2>{3, 4});
  root["v"].read_singles(values);
  CHECK(values == std::array<float, 2>{1, 2.5f});
}

TEST_CASE("what is wrong with a field is told with its place and the status of the root") {
  const json text = parse_json<json>(
      R"({"a": [{"n": 4294967296, "x": 1e39, "z": "a\u0000b", "w": "up", "e": [], "v": [1, -1]}]})", "text");
  const JsonField a = JsonField(text, "text:", Status::rig)["a"].items().at(0);
  const auto refused = [](const char* message, auto&& read, Status status = Status::rig) {
    CHECK(failure(status, read) == message);
  };
  refused("text: a[0] n is no whole number from 0 to 4294967295", [&] { a["n"].count(); });
  refused("text: a[0] x is no whole number from 1 to 4294967295", [&] { a["x"].count(1); });
  refused("text: a[0] x is too large for a float", [&] { a["x"].single(); });
  refused("text: a[0] x is no string", [&] { a["x"].text_or(""); });
  refused("text: a[0] x is no object", [&] { a["x"]["y"]; });
  refused("text: a[0] x is neither true nor false", [&] { a["x"].flag_or(true); });
  refused("text: a[0] z holds a zero byte", [&] { a["z"].text(); });
  refused("text: a[0] z is no number", [&] { a["z"].number(); });
  refused("text: a[0] z is no list", [&] { a["z"].items(); });
  refused("text: a[0] w is \"up\"; there are left, right", [&] { a["w"].word_or(0, words); });
  refused("text: a[0] w is no hexadecimal number", [&] { a["w"].hash(); });
  refused("text: a[0] e is empty", [&] { a["e"].nonempty_items(); });
  refused("text: a[0] v[1] is no whole number from 0 to 4294967295", [&] { a["v"].counts(); });
  std::array<float, 3> values;
  refused("text: a[0] v has 2 numbers, not 3", [&] { a["v"].read_singles(values); });
  refused("text: a[0] none is missing", [&] { a["none"].nonempty_text(); });
  refused("text: a[0] none is missing", [&] { a["none"]["more"]; });
  refused(
      "text: a[0] w up is bad",
      [&] { a["w"].read_or(0, [](const std::string& w) -> int { fail(Status::limit, "%s is bad", w.c_str()); }); },
      Status::limit);
  const json infinite = std::numeric_limits<double>::infinity();
  refused(
      "text is not finite", [&] { JsonField(infinite, "text").number(); }, Status::not_finite);
}

TEST_CASE("a text that is no JSON is refused with its name and place") {
  const std::string deep = std::string(65, '[') + std::string(65, ']');
  for (const auto& [text, message] : {std::pair<std::string, const char*>{"{\n\"a\": nil}", "line 2, column 7: "},
                                      {"[\"\xff\"]", "ill-formed UTF-8 byte; last read: '\"\\xff'"},
                                      {"[1e999]", "name: is no JSON: number overflow parsing '1e999'"},
                                      {deep, "name: JSON: byte 64 lies more than 64 objects and arrays deep"}}) {
    const std::string seen = failure(Status::rig, [&, text = text] { parse_json<json>(text, "name", Status::rig); });
    CHECK_MESSAGE(contains(seen, message), seen);
    CHECK(seen.starts_with("name: "));
    CHECK(object_in(text).is_null());
  }
  CHECK(failure(Status::bad_data, [] { parse_json<ordered_json>(std::string(100000, '"'), "name"); }).size() < 300);
  CHECK(object_in("[]").is_null());
  CHECK(object_in(R"({"b": 1, "a": 2})").dump() == R"({"b":1,"a":2})");
}

}  // namespace test_json_field
