// Whose leave a bake needs: consents that lift what rights forbid, and whom they are about.
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/leave_to_learn.h"
#include "bake/rig/json_field.h"
#include "bake_test_support.h"
#include "signing/signed_consent.h"
#include "toy_faces.h"
#include "watched_progress.h"

namespace test_leave_to_learn {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

const std::string source_sha256(64, 'a');

std::string consent_text(const std::string& performer, const std::string& agreement, const std::string& rest) {
  return R"({"format": "facebaker-consent", "version": 1, "performer": ")" + performer + R"(", "agreement": ")" +
         agreement + R"(", )" + rest + "}";
}

const std::string learning = R"("permits": ["learning"])";

MemorySource character(const std::string& rights) {
  MemorySource source = curved_face();
  source.edit_character().about = R"({"rights":)" + rights + "}";
  return source;
}

const char* const forbidden = R"({"learning":"forbidden","performer":"Ada","agreement":"A-7"})";

BakeOptions with(const SignedConsent& consent) {
  BakeOptions options;
  options.consent = consent.file.string();
  options.consent_key = consent.key.string();
  options.source_files = {{"rig.so", 10, source_sha256}};
  return options;
}

std::string refusal(const std::string& consent, const std::string& rights, Status status = Status::invalid_argument) {
  const SignedConsent made(consent);
  const MemorySource source = character(rights);
  return failure(status,
                 [&] { leave_to_learn({"hero"}, source, source.character().about, with(made), silent_progress()); });
}

}  // namespace

TEST_CASE("a signed consent lets a recipe learn, and the archive keeps whose it was") {
  const SignedConsent made(consent_text("Ada", "A-7", learning + R"(, "expires": "2090-12-31")"));
  MemorySource source = character(forbidden);
  const WorkFolder folder;
  BakeOptions options = with(made);
  options.recipe = "linear";
  options.work = folder.path;
  const PackedModel model = archive::read_archive(bake_face(source, options, silent_progress()).archive).model;
  const auto provenance = object_in(model.provenance);
  CHECK(provenance.at("learned") == "yes");
  const auto& kept = provenance.at("consent");
  CHECK(kept.at("agreement") == "A-7");
  CHECK(kept.at("permits").at(0) == "learning");
  CHECK(kept.at("expires") == "2090-12-31");
  CHECK(kept.at("signed_by") == "CN = Ada's agent");
  CHECK(kept.at("sha256").get<std::string>().size() == 64);
  CHECK(kept.at("key_sha256").get<std::string>().size() == 64);
  // Others still may not learn from the face.
  CHECK(object_in(model.character.about).at("rights").at("learning") == "forbidden");
}

TEST_CASE("a consent is about one character") {
  CHECK(contains(refusal(consent_text("Ada", "A-8", learning), forbidden),
                 "its agreement is \"A-8\", the character's is \"A-7\""));
  CHECK(contains(refusal(consent_text("Bo", "A-7", learning), forbidden), "its performer is \"Bo\""));
  CHECK(contains(refusal(consent_text("Ada", "A-7", learning), R"({"learning":"forbidden"})"),
                 "names no source, and the rights of the character no agreement"));
  const std::string other = R"(, "sources": [{"sha256": ")" + std::string(64, 'b') + R"("}])";
  CHECK(contains(refusal(consent_text("Ada", "A-7", learning + other), forbidden), "is not about \"rig.so\""));
  const std::string own = R"(, "sources": [{"sha256": ")" + source_sha256 + R"("}])";
  const SignedConsent made(consent_text("Ada", "A-7", learning + own));
  const MemorySource source = character(R"({"learning":"forbidden"})");
  CHECK(leave_to_learn({"hero"}, source, source.character().about, with(made), silent_progress()));
  BakeOptions without_files = with(made);
  without_files.source_files.clear();
  CHECK(contains(
      failure(Status::invalid_argument,
              [&] { leave_to_learn({"hero"}, source, source.character().about, without_files, silent_progress()); }),
      "this source has no file"));
}

TEST_CASE("a consent to something else, and one that another key signed, let nobody learn") {
  CHECK(contains(refusal(consent_text("Ada", "A-7", R"("permits": ["film"])"), forbidden),
                 "does not permit \"learning\""));
  const SignedConsent made(consent_text("Ada", "A-7", learning)), other(consent_text("Ada", "A-7", learning));
  const MemorySource source = character(forbidden);
  BakeOptions options = with(made);
  options.consent_key = other.key.string();
  failure(Status::bad_data,
          [&] { leave_to_learn({"hero"}, source, source.character().about, options, silent_progress()); });
  options.consent_key.clear();
  CHECK(
      contains(failure(Status::invalid_argument,
                       [&] { leave_to_learn({"hero"}, source, source.character().about, options, silent_progress()); }),
               "consent without consent_key"));
}

TEST_CASE("a consent that is given is checked where nobody needs it") {
  const SignedConsent made(consent_text("Ada", "A-8", learning));
  const MemorySource source = character(R"({"agreement":"A-7"})");
  failure(Status::invalid_argument,
          [&] { leave_to_learn({"untrained"}, source, source.character().about, with(made), silent_progress()); });
}

TEST_CASE("what nobody may train on, nobody may learn from, and constraints are told") {
  const MemorySource source = character("{}");
  const auto ask = [&](const std::string& rights, Progress& progress) {
    leave_to_learn({"hero"}, source, R"({"rights":)" + rights + "}", {}, progress);
  };
  CHECK(contains(failure(Status::invalid_argument,
                         [&] { ask(R"({"learning":"allowed","ai_training":"notAllowed"})", silent_progress()); }),
                 "(ai_training: notAllowed), and the recipe \"hero\" learns: \"untrained\" does not"));
  Notes progress;
  ask(R"({"ai_training":"constrained","constraint_info":"of film X alone"})", progress);
  CHECK_MESSAGE(contains(progress.all, "of film X alone"), progress.all);
  progress.all.clear();
  ask(R"({"learning":"allowed"})", progress);
  CHECK(progress.all.empty());
  ask(R"({"expires":"2020-02-29"})", progress);
  CHECK_MESSAGE(contains(progress.all, "ended on 2020-02-29"), progress.all);
}

}  // namespace test_leave_to_learn
