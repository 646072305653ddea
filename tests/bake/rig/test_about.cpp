// What is said about a character: read from anyone, put over what a source says.
#include "bake/rig/about.h"

#include <nlohmann/json.hpp>

#include "bake_test_support.h"

namespace test_about {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

TEST_CASE("what is given comes before what a source says, field by field") {
  const std::string source = R"({"author":"Ada","rights":{"uses":"film","learning":"allowed"},"shelf":[1,2]})";
  CHECK(merged_about(source, "") == source);
  CHECK(merged_about("", "") == "");
  CHECK(merged_about("", "{ }") == "");
  CHECK(merged_about(R"({"author":null,"rights":null,"rig":"3"})", "") == R"({"rig":"3"})");
  CHECK(merged_about(R"({"rig":"3"})", R"({"rig":null})") == "");
  CHECK(merged_about("", R"({ "rig" : "mine" })") == R"({"rig":"mine"})");
  CHECK(merged_about(source, R"({"rig":"3","rights":{"learning":"forbidden","uses":null},"shelf":null})") ==
        R"({"author":"Ada","rights":{"learning":"forbidden"},"rig":"3"})");
}

TEST_CASE("a licence among the rights is taken out, for a section of its own") {
  std::string about = R"({"author":"Ada","rights":{"licence":"CC0-1.0","uses":"any"}})";
  CHECK(take_licence(about) == "CC0-1.0");
  CHECK(about == R"({"author":"Ada","rights":{"uses":"any"}})");
  CHECK(take_licence(about) == "");
  about = R"({"rights":{"licence":"CC0-1.0"}})";
  CHECK(take_licence(about) == "CC0-1.0");
  CHECK(about == "");
  CHECK(take_licence(about) == "");
}

TEST_CASE("what is given can put right what a source says wrongly") {
  const std::string source = R"({"author":7,"rights":{"ai_training":"never","uses":"film"}})";
  CHECK(failure(Status::bad_data, [&] { merged_about(source, ""); }) == "about: author is no string");
  CHECK(merged_about(source, R"({"author":"Ada","rights":{"ai_training":"notAllowed"}})") ==
        R"({"author":"Ada","rights":{"ai_training":"notAllowed","uses":"film"}})");
  CHECK(merged_about(R"({"rights":"none"})", R"({"rights":{"uses":"film"}})") == R"({"rights":{"uses":"film"}})");
  CHECK(failure(Status::bad_data, [] { merged_about("[]", R"({"rig":"3"})"); }) == "about: is no object");
}

TEST_CASE("whether learning is forbidden is read from the rights alone") {
  CHECK(forbids_learning(R"({"rights":{"learning":"forbidden"}})"));
  for (const char* about : {"", "{}", R"({"learning":"forbidden"})", R"({"rights":{"learning":"allowed"}})"})
    CHECK(!forbids_learning(about));
}

TEST_CASE("what is no such object is refused by field") {
  const auto refused = [](const std::string& text, Status status, const char* message) {
    const std::string seen = failure(status, [&] { merged_about("", text); });
    CHECK_MESSAGE(seen.find(message) != std::string::npos, seen);
  };
  for (const char* text : {"[1]", "7"}) refused(text, Status::bad_data, "about: is no object");
  for (const char* text : {"{", "{} {}", "nonsense"})
    refused(text, Status::bad_data, "about: is no JSON: parse error at line 1, column ");
  for (const char* key : {"name", "author", "contact", "rig", "rig_version", "created"})
    refused(format("{\"%s\": 1}", key), Status::bad_data, format("about: %s is no string", key).c_str());
  for (const char* key : {"licence", "consent", "uses", "expires", "learning"})
    refused(format("{\"rights\": {\"%s\": []}}", key), Status::bad_data,
            format("about: rights %s is no string", key).c_str());
  refused(R"({"rights": "all"})", Status::bad_data, "about: rights is no object");
  refused("{\"author\": \"\xff\"}", Status::bad_data, "about: is no JSON: parse error at line 1, column 13");
  refused("{\"a\": " + std::string(100, '[') + std::string(100, ']') + "}", Status::bad_data, "deep");
  refused("{\"author\": \"" + std::string(65536, 'a') + "\"}", Status::limit, "it may have 65536");
}

}  // namespace test_about
