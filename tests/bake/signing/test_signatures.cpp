// Detached signatures: made, checked, and refused by name.
#include <cstring>
#include <span>

#include "signing/signed_content.h"

namespace test_signatures {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

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
    CHECK(facts.signed_at.substr(0, 8) == this_day().substr(0, 8));
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

TEST_CASE("no byte of a signature can be changed, and none be left out") {
  for (EVP_PKEY* key : {EVP_EC_gen("P-256"), EVP_RSA_gen(2048)}) {
    const SignedContent made{SigningTestKey(key)};
    const std::vector<TrustedFile> trusted = read_trusted({made.folder / "signer.pem"});
    write_file(made.folder / "key.pub", made.signer.public_pem());
    const std::vector<TrustedFile> by_key = read_trusted({made.folder / "key.pub"});
    const auto refused = [&](std::span<const std::byte> signature, std::span<const TrustedFile> trust) {
      try {
        check_signature(made.content, signature, trust, {.day = this_day()});
        return false;
      } catch (const Error& error) {
        return error.status() != Status::internal && std::strlen(error.what()) > 0;
      }
    };
    std::vector<std::byte> signature = made.signature;
    for (std::size_t size = 0; size < signature.size(); ++size) {
      CAPTURE(size);
      CHECK(refused(std::span(signature).first(size), trusted));
    }
    for (std::size_t at = 0; at < signature.size(); ++at)
      for (const int flip : {0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40, 0x80, 0xff}) {
        CAPTURE(at);
        CAPTURE(flip);
        signature[at] ^= std::byte(flip);
        CHECK(refused(signature, trusted));
        CHECK(refused(signature, by_key));
        signature[at] ^= std::byte(flip);
      }
    CHECK(!refused(signature, trusted));
    CHECK(!refused(signature, by_key));
    signature.push_back({});
    CHECK(refused(signature, trusted));
  }
}

}  // namespace test_signatures
