// Consents: read, and held to their signature and their days.
#include "bake/signing/consent.h"

#include "signing/signed_consent.h"
#include "signing/signed_content.h"

namespace test_consent {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

const char* const whole = R"({"format": "facebaker-consent", "version": 1, "performer": "Ada", "agreement": "A-7",
  "permits": ["learning", "film"], "expires": "2090-12-31",
  "sources": [{"sha256": "00112233445566778899AABBCCDDEEFF00112233445566778899aabbccddeeff"}]})";

TEST_CASE("a consent that is signed says what is permitted") {
  const SignedConsent made(whole);
  const Consent consent = verified_consent(made.file, made.key, this_day());
  CHECK(consent.performer == "Ada");
  CHECK(consent.agreement == "A-7");
  CHECK(consent.expires == "2090-12-31");
  CHECK(consent.permits_use("learning"));
  CHECK(!consent.permits_use("games"));
  CHECK(consent.sources ==
        std::vector<std::string>{"00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff"});
  CHECK(consent.sha256.size() == 64);
  CHECK(consent.signature.signer.subject == "CN = Ada's agent");
  CHECK(consent.signature.trusted_by == TrustedBy::public_key);
}

TEST_CASE("a consent that was changed, has expired or is not signed is refused, naming the file") {
  SignedConsent made(R"({"format": "facebaker-consent", "version": 1, "performer": "Ada", "agreement": "A-7",
                         "permits": ["learning"], "expires": "2026-01-31"})");
  CHECK(holds(made.refusal(), "the consent of Ada has expired: it held until 2026-01-31, and this is " + this_day() +
                                  " (" + made.file.string() + ")"));
  write_file(made.file, whole);
  CHECK(
      holds(made.refusal(), "the signature is of other bytes: the file was changed after CN = Ada's agent signed it"));
  CHECK(holds(made.refusal(), "consent.json.sig)"));
  std::filesystem::remove(made.folder / "consent.json.sig");
  CHECK(holds(made.refusal(Status::not_found), "consent.json.sig"));
}

TEST_CASE("what is signed and is no consent is refused, naming field and fault") {
  const auto refused = [](const char* text, Status status = Status::bad_data) {
    return SignedConsent(text).refusal(status);
  };
  CHECK(holds(refused("yes"), "consent.json: is no JSON"));
  CHECK(holds(refused(R"({"format": "facebaker-withdrawals"})"),
              "consent.json: format is 'facebaker-withdrawals' where 'facebaker-consent' is expected"));
  CHECK(holds(refused(R"({"format": "facebaker-consent", "version": 2})", Status::unsupported),
              "version is 2; this program reads 1"));
  const std::string begin = R"({"format": "facebaker-consent", "version": 1, "performer": "Ada", )";
  CHECK(holds(refused((begin + "\"permits\": []}").c_str()), "agreement is missing"));
  CHECK(holds(refused((begin + R"("agreement": "A", "permits": []})").c_str()), "permits is empty"));
  CHECK(holds(refused((begin + R"("agreement": "A", "permits": ["x"], "expires": "soon"})").c_str()),
              "expires is 'soon', which is no day: write it like 2031-12-31"));
  CHECK(holds(refused((begin + R"("agreement": "A", "permits": ["x"], "sources": [{"sha256": "12"}]})").c_str()),
              "sources[0] sha256 is '12', which is no SHA-256 of 64 hexadecimal digits"));
}

}  // namespace test_consent
