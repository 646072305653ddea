// What may be done with a character: fields that disagree, days, and what is not as TEXTS.md has it.
#include "bake/rights/rights.h"

#include <nlohmann/json.hpp>

#include "bake/rig/about.h"
#include "bake/rights/binding_rights.h"
#include "bake/rights/rights_terms.h"
#include "bake_test_support.h"
#include "base/file.h"

namespace test_rights {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

Rights rights(const std::string& fields) {
  return rights_in("{\"rights\":{" + fields + "}}");
}

// What the four permissions are, in order: "u" unstated, "a" allowed, "c" constrained, "n" not allowed.
std::string permissions(const std::string& fields) {
  const Rights said = rights(fields);
  std::string text;
  for (const Permission permission : {said.learning_permission(), said.training_permission(),
                                      said.generative_training_permission(), said.mining_permission()})
    text += "uacn"[static_cast<int>(permission)];
  return text;
}

bool expired(const std::string& expires, const char* on) {
  return rights("\"expires\":\"" + expires + "\"").expired(*calendar_day_in(on));
}

}  // namespace

TEST_CASE("where fields disagree the stricter holds") {
  CHECK(permissions("") == "uuuu");
  CHECK(permissions(R"("learning":"allowed")") == "aaau");
  CHECK(permissions(R"("learning":"forbidden")") == "nnnu");
  CHECK(permissions(R"("learning":"on request")") == "cccu");
  CHECK(permissions(R"("learning":"allowed","ai_training":"notAllowed")") == "nnau");
  CHECK(permissions(R"("learning":"forbidden","ai_training":"allowed","ai_generative_training":"allowed")") == "nnnu");
  CHECK(permissions(R"("learning":"allowed","ai_generative_training":"notAllowed")") == "nanu");
  CHECK(permissions(R"("ai_training":"allowed")") == "aauu");
  CHECK(permissions(R"("data_mining":"notAllowed")") == "uuun");
  CHECK(permissions(R"("learning":"on request","data_mining":"allowed")") == "ccca");
}

TEST_CASE("what is constrained without a word on how is not allowed") {
  CHECK(permissions(R"("ai_training":"constrained")") == "nnuu");
  CHECK(permissions(R"("ai_training":"constrained","constraint_info":"see ada.example")") == "ccuu");
  CHECK(permissions(R"("learning":"allowed","data_mining":"constrained","constraint_info":"in Europe")") == "aaac");
  CHECK(permissions(R"("learning":"forbidden","ai_training":"constrained","constraint_info":"a")") == "nnnu");
}

TEST_CASE("forbids_learning is the strictest of the three") {
  for (const char* fields : {R"("learning":"forbidden")", R"("ai_training":"notAllowed","learning":"allowed")",
                             R"("ai_generative_training":"notAllowed")", R"("ai_training":"constrained")"})
    CHECK_MESSAGE(forbids_learning(std::string("{\"rights\":{") + fields + "}}"), fields);
  for (const char* fields : {R"("ai_training":"constrained","constraint_info":"ask")", R"("data_mining":"notAllowed")",
                             R"("ai_training":"allowed")"})
    CHECK_MESSAGE(!forbids_learning(std::string("{\"rights\":{") + fields + "}}"), fields);
}

TEST_CASE("rights hold to the end of their last day") {
  CHECK(!expired("2031-12-31", "2031-12-31"));
  CHECK(expired("2031-12-31", "2032-01-01"));
  CHECK(!expired("2024-02-29", "2024-02-29"));
  CHECK(expired("2024-02-29", "2024-03-01"));
  CHECK(!expired("2031-12-31T23:59:59Z", "2031-12-31"));
  CHECK(expired("2031-12-31T12:00:00Z", "2031-12-31"));
  CHECK(!expired("2032-01-01T00:00:00+01:00", "2031-12-30"));
  CHECK(expired("2032-01-01T00:00:00+01:00", "2031-12-31"));
  for (const char* words : {"", "2023-02-29", "when the film is out", "31.12.2020"})
    CHECK(!expired(words, "9999-12-31"));
  CHECK(!rights(R"("expires":"31.12.2020")").last_day());
}

TEST_CASE("what an archive says otherwise than it should is kept as words, and read strictly") {
  CHECK(permissions(R"("ai_training":"never")") == "nnuu");
  CHECK(permissions(R"("data_mining":false)") == "uuun");
  CHECK(permissions(R"("learning":["film"])") == "cccu");
  CHECK(permissions(R"("ai_training":"","learning":null)") == "uuuu");
  const Rights said = rights(R"("data_mining":false,"suspendable":"ask","digital_source_type":"drawn")");
  CHECK(said.data_mining == "false");
  CHECK(said.can_be_suspended());
  CHECK(said.unread == std::vector<std::string>{"rights suspendable is \"ask\", which is none of its terms",
                                                "rights digital_source_type is \"drawn\", which is none of its terms",
                                                "rights data_mining is no string, but false"});
  CHECK(!rights(R"("suspendable":"no")").can_be_suspended());
  CHECK(!rights("").can_be_suspended());
}

TEST_CASE("rights that cannot be read allow nothing, and nothing said is nothing") {
  for (const std::string& about : {std::string("nonsense"), std::string("[7]"), std::string(60000, '['),
                                   std::string(R"({"rights":"all reserved"})"), std::string("{\"rights\":7}")}) {
    const Rights said = rights_in(about);
    CHECK(said.unreadable);
    CHECK(!said.empty());
    CHECK(said.learning_permission() == Permission::not_allowed);
    CHECK(said.mining_permission() == Permission::not_allowed);
    CHECK(said.unread.size() == 1);
  }
  for (const char* about : {"", "{}", R"({"rights":null})", R"({"rights":{}})", R"({"rights":{"shelf":7}})",
                            R"({"author":"Ada","rights":{"learning":""}})"})
    CHECK_MESSAGE(rights_in(about).empty(), about);
}

TEST_CASE("what binds is said in words, what ended first") {  // the viewer says the same, by the same cases
  const auto bytes = read_file(FB_RIGHTS_CASES);
  const auto cases = nlohmann::json::parse(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  REQUIRE(cases.size() > 30);
  for (const nlohmann::json& one : cases) {
    const std::string about = one.at("about");
    CAPTURE(about);
    const CalendarDay on = *calendar_day_in(one.at("on").get<std::string>());
    CHECK(rights_in(about).expired(on) == one.at("expired"));
    CHECK(binding_rights(rights_in(about), on) == one.at("binding").get<std::vector<std::string>>());
  }
}

TEST_CASE("the document has what is said, as strict as it is") {
  const auto document = [](const std::string& fields) {
    return rights_document(rights(fields), *calendar_day_in("2026-01-01"));
  };
  CHECK(document("").dump() == R"({"on":"2026-01-01","expired":false,"binding":[],"unread":[]})");
  CHECK(
      document(R"("learning":"allowed","ai_training":"notAllowed","expires":"2025-12-31","suspendable":"no")").dump() ==
      R"({"on":"2026-01-01","expired":true,"last_day":"2025-12-31","learning":"forbidden","ai_training":"notAllowed",)"
      R"("ai_generative_training":"allowed","suspendable":false,"binding":["expired: the rights ended on 2025-12-31",)"
      R"~("learning from it is forbidden (ai_training: notAllowed)"],"unread":[]})~");
  CHECK(document(R"("data_mining":"constrained","constraint_info":"ask")").at("data_mining") == "constrained");
  CHECK(document(R"("data_mining":7)").at("unread").dump() == R"(["rights data_mining is no string, but 7"])");
}

TEST_CASE("words of rights stay in their line and are cut") {
  const std::vector<std::string> binding =
      binding_rights(rights("\"uses\":\"a\\nb\\u001b[2J" + std::string(1000, 'c') + "\""), today());
  REQUIRE(binding.size() == 1);
  CHECK(binding[0].find_first_of("\n\x1b") == std::string::npos);
  CHECK(binding[0].size() < 300);
}

TEST_CASE("every field is read, and refused by name when it is given wrongly") {
  const auto refused = [](const std::string& fields) {
    return failure(Status::bad_data, [&] { merged_about("", "{\"rights\":{" + fields + "}}"); });
  };
  for (const RightsField& field : rights_fields()) {
    const std::string value(field.terms.empty() ? "words" : field.terms[0]);
    const std::string given = format("\"%s\":\"%s\"", field.key, value.c_str());
    CHECK(rights(given).*field.value == value);
    CHECK(merged_about("", "{\"rights\":{" + given + "}}") == "{\"rights\":{" + given + "}}");
    CHECK(refused(format("\"%s\":7", field.key)) == format("about: rights %s is no string", field.key));
    if (!field.terms.empty())
      CHECK(refused(format("\"%s\":\"Yes\"", field.key)).find("it may be \"") != std::string::npos);
  }
  CHECK(refused(R"("ai_training":"forbidden")") ==
        R"(about: rights ai_training is "forbidden"; it may be "allowed", "notAllowed" or "constrained")");
  CHECK(refused(R"("suspendable":"true")") == R"(about: rights suspendable is "true"; it may be "yes" or "no")");
}

TEST_CASE("a digital source type is a term of IPTC's, or a URI") {
  const auto accepted = [](const std::string& type) {
    return rights("\"digital_source_type\":\"" + type + "\"").unread.empty();
  };
  for (const char* type : {"digitalCapture", "http://cv.iptc.org/newscodes/digitalsourcetype/digitalCapture",
                           "https://cv.iptc.org/newscodes/digitalsourcetype/compositeSynthetic",
                           "http://c2pa.org/digitalsourcetype/trainedAlgorithmicData"})
    CHECK_MESSAGE(accepted(type), type);
  for (const char* type : {"DigitalCapture", "drawing", "http://cv.iptc.org/newscodes/digitalsourcetype/drawing"})
    CHECK_MESSAGE(!accepted(type), type);
}

}  // namespace test_rights
