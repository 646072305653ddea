// Detached signatures: made, checked, and refused by name.
#include <cstring>
#include <string_view>

#include "bake/signing/check_signature.h"
#include "bake/signing/content_digest.h"
#include "bake/signing/key_files.h"
#include "bake/signing/sign_bytes.h"
#include "bake_test_support.h"
#include "base/calendar_day.h"
#include "signing_keys.h"

namespace test_signatures {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string day_from_now(int days) {
  const auto day = std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()) + std::chrono::days(days);
  const std::chrono::year_month_day parts(day);
  return format("%04d-%02u-%02u", int(parts.year()), unsigned(parts.month()), unsigned(parts.day()));
}

// What is signed, by whom, in a folder.
struct SignedContent {
  explicit SignedContent(SigningTestKey signer) : signer(std::move(signer)) {
    write_file(folder / "key.pem", this->signer.key_pem() + this->signer.certificate_pem());
    write_file(folder / "signer.pem", this->signer.certificate_pem());
    signature = sign_bytes(content, read_signing_key(folder / "key.pem", "", {}));
  }

  SignatureFacts check(const SignatureRules& rules = {.day = calendar_day_text(today())}) const {
    return check_signature(content, signature, read_trusted({folder / "signer.pem"}), rules);
  }
  std::string refusal(const SignatureRules& rules = {.day = calendar_day_text(today())},
                      Status status = Status::bad_data) const {
    return failure(status, [&] { check(rules); });
  }

  Folder folder;
  SigningTestKey signer;
  std::vector<std::byte> content = bytes_of("a face"), signature;
};

bool holds(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST_CASE("a signature says who signed, when and by which key, of every kind of key that signs") {
  struct Kind {
    EVP_PKEY* key;
    const char *name, *digest;
  };
  for (const Kind& kind :
       {Kind{EVP_RSA_gen(2048), "RSA 2048", "SHA-256"}, Kind{EVP_EC_gen("P-256"), "P-256", "SHA-256"},
        Kind{EVP_EC_gen("P-384"), "P-384", "SHA-384"}, Kind{EVP_EC_gen("P-521"), "P-521", "SHA-512"}}) {
    CAPTURE(kind.name);
    const SignedContent made(SigningTestKey(kind.key, "Ada Löw"));
    const SignatureFacts facts = made.check();
    CHECK(facts.signer.subject == "CN = Ada Löw");
    CHECK(facts.signer.issuer == "CN = Ada Löw");
    CHECK(facts.signer.key_kind == kind.name);
    CHECK(facts.digest == kind.digest);
    CHECK(facts.signer.key_sha256.size() == 64);
    CHECK(facts.signer.valid_from == day_from_now(-1));
    CHECK(facts.signer.valid_until == day_from_now(3650));
    CHECK(facts.signed_at.substr(0, 8) == calendar_day_text(today()).substr(0, 8));
    CHECK(facts.trusted_by == TrustedBy::certificate);
    CHECK(facts.trusted_file == made.folder / "signer.pem");
    CHECK(!facts.expired);
  }
}

TEST_CASE("other bytes, other signers and days out of the certificate's are refused by name") {
  SignedContent made(SigningTestKey(new_curve_key(), "Ada", {.last_day = 10}));
  made.content.back() ^= std::byte{1};
  CHECK(holds(made.refusal(), "is of other bytes: the file was changed after CN = Ada signed it at 20"));
  made.content.back() ^= std::byte{1};
  CHECK(holds(made.refusal({.day = day_from_now(11)}), "is by CN = Ada, whose certificate has expired by "));
  CHECK(holds(made.refusal({.day = day_from_now(11)}), "accept that by --accept-expired"));
  CHECK(made.check({.day = day_from_now(11), .accept_expired = true}).expired);
  CHECK(!made.check({.day = day_from_now(10)}).expired);
  CHECK(holds(made.refusal({.day = day_from_now(-1)}), "says that it was signed at 20"));
  const SigningTestKey other(new_curve_key(), "Bob");
  write_file(made.folder / "signer.pem", other.certificate_pem());
  CHECK(holds(made.refusal(), "is intact, but by somebody who is not trusted: CN = Ada, whose key has the SHA-256 "));
  CHECK(holds(made.refusal(), "; trusted are: CN = Bob"));
}

}  // namespace test_signatures
