// Signatures as others make them: by certificates of an authority, in other forms, or none at all.
#include <openssl/cms.h>

#include <cstdlib>

#include "signing/signed_content.h"

namespace test_foreign_signatures {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

// A signature by OpenSSL alone, with flags of CMS_sign, and by a second signer where one is given.
std::vector<std::byte> cms_of(const SigningTestKey& signer, std::string_view content, unsigned flags,
                              const EVP_MD* digest = EVP_sha256(), const SigningTestKey* second = nullptr) {
  const std::unique_ptr<BIO, int (*)(BIO*)> in(BIO_new_mem_buf(content.data(), static_cast<int>(content.size())),
                                               BIO_free);
  const std::unique_ptr<CMS_ContentInfo, void (*)(CMS_ContentInfo*)> message(
      CMS_sign(nullptr, nullptr, nullptr, in.get(), flags | CMS_BINARY | CMS_PARTIAL), CMS_ContentInfo_free);
  REQUIRE(message != nullptr);
  REQUIRE(CMS_add1_signer(message.get(), signer.certificate(), signer.key(), digest, flags) != nullptr);
  if (second) REQUIRE(CMS_add1_signer(message.get(), second->certificate(), second->key(), digest, flags) != nullptr);
  REQUIRE(CMS_final(message.get(), in.get(), nullptr, flags | CMS_BINARY) == 1);
  unsigned char* der = nullptr;
  const int size = i2d_CMS_ContentInfo(message.get(), &der);
  const auto bytes = std::as_bytes(std::span(der, static_cast<std::size_t>(size)));
  const std::vector<std::byte> copy(bytes.begin(), bytes.end());
  OPENSSL_free(der);
  return copy;
}

TEST_CASE("what OpenSSL signs is read, whether it names the certificate or the key") {
  SignedContent made{SigningTestKey(new_curve_key(), "Ada")};
  made.signature = cms_of(made.signer, "a face", CMS_DETACHED, EVP_sha512());
  CHECK(made.check().digest == "SHA-512");
  CHECK(made.check().signer.subject == "CN = Ada");
  made.signature = cms_of(made.signer, "a face", CMS_DETACHED | CMS_USE_KEYID);
  CHECK(made.check().signer.subject == "CN = Ada");
  made.signature = cms_of(made.signer, "another face", CMS_DETACHED);
  CHECK(holds(made.refusal(), "is of other bytes"));
}

TEST_CASE("forms that say too little or too much are refused by name") {
  SignedContent made{SigningTestKey(new_curve_key(), "Ada")};
  const SigningTestKey second(new_curve_key(), "Bob");
  const auto refusal_of = [&](const std::vector<std::byte>& signature, Status status = Status::bad_data) {
    made.signature = signature;
    return made.refusal({.day = this_day()}, status);
  };
  CHECK(holds(refusal_of(cms_of(made.signer, "a face", CMS_DETACHED, EVP_sha256(), &second)),
              "has 2 signers; it must have one"));
  CHECK(holds(refusal_of(cms_of(made.signer, "a face", 0)), "holds what it signs: it must be detached"));
  CHECK(holds(refusal_of(cms_of(made.signer, "a face", CMS_DETACHED | CMS_NOATTR)), "does not say when it was signed"));
  CHECK(holds(refusal_of(cms_of(made.signer, "a face", CMS_DETACHED | CMS_NOCERTS)),
              "has not the certificate of its signer in it"));
  CHECK(holds(refusal_of(cms_of(made.signer, "a face", CMS_DETACHED, EVP_sha1()), Status::unsupported),
              "has the digest sha1; known are SHA-256, SHA-384 and SHA-512"));
  CHECK(holds(refusal_of(bytes_of("a face")), "is none: CMS in DER is expected"));
  CHECK(holds(refusal_of({}), "is none: CMS in DER is expected"));
  CHECK(holds(refusal_of(bytes_of("-----BEGIN CMS-----\n")), "is PEM: a signature is DER"));
  CHECK(holds(refusal_of(std::vector<std::byte>((1 << 20) + 1), Status::limit), "is none: it has 1048577 bytes"));
  std::vector<std::byte> cut = cms_of(made.signer, "a face", CMS_DETACHED);
  cut.resize(cut.size() / 2);
  CHECK(holds(refusal_of(cut), "is cut short or damaged"));
}

TEST_CASE("an authority's certificate stands for those that it issued, as long as all of them hold") {
  const SigningTestKey root(new_curve_key(), "Guild", {.constraints = "critical,CA:TRUE"});
  const SigningTestKey branch(new_curve_key(), "Branch", {.last_day = 20, .constraints = "critical,CA:TRUE"}, &root);
  SignedContent made{SigningTestKey(new_curve_key(), "Ada", {.key_usage = "digitalSignature"}, &branch)};
  write_file(made.folder / "chain.pem", made.signer.certificate_pem() + branch.certificate_pem());
  made.signature = sign_bytes(made.content, read_signing_key(made.folder / "key.pem", made.folder / "chain.pem", {}));

  for (const SigningTestKey* trusted : {&root, &branch}) {
    made.trust(trusted->certificate_pem());
    const SignatureFacts facts = made.check();
    CHECK(facts.trusted_by == TrustedBy::issuer);
    CHECK(facts.trusted == (trusted == &root ? "CN = Guild" : "CN = Branch"));
    CHECK(facts.signer.issuer == "CN = Branch");
    CHECK(holds(made.refusal({.day = day_from_now(21)}),
                "is by a certificate of CN = Branch, whose certificate has expired"));
    CHECK(!made.check({.day = day_from_now(21), .accept_expired = true}).expired);
  }
  made.trust(SigningTestKey(new_curve_key(), "Branch", {.constraints = "critical,CA:TRUE"}).certificate_pem());
  CHECK(holds(made.refusal(), "by somebody who is not trusted: CN = Ada"));

  // Ada's certificate is no authority's, and does not make one of her.
  const SignedContent by_friend{SigningTestKey(new_curve_key(), "Friend", {}, &made.signer)};
  by_friend.trust(made.signer.certificate_pem());
  CHECK(holds(by_friend.refusal(), "by somebody who is not trusted: CN = Friend"));
}

TEST_CASE("a certificate that is not for signatures, or another with the same key, is refused") {
  SignedContent made{SigningTestKey(new_curve_key(), "Ada")};
  EVP_PKEY_up_ref(made.signer.key());
  const SigningTestKey renamed(made.signer.key(), "Bob");
  made.trust(renamed.certificate_pem());
  CHECK(holds(made.refusal(), "by somebody who is not trusted: CN = Ada"));
  const SigningTestKey encrypts(new_curve_key(), "Eve", {.key_usage = "keyEncipherment"});
  made.signature = cms_of(encrypts, "a face", CMS_DETACHED);
  CHECK(holds(made.refusal(), "is by CN = Eve, whose certificate is not for signatures: its key usage"));
}

TEST_CASE("openssl agrees with signatures of ours, and we with its own") {
  if (std::system("openssl version >/dev/null 2>&1") != 0) {
    MESSAGE("skipped: there is no openssl command");
    return;
  }
  SignedContent made{SigningTestKey(EVP_RSA_gen(2048), "Ada")};
  write_file(made.folder / "face.fbk", made.content);
  write_file(made.folder / "face.sig", made.signature);
  const auto run = [&](const std::string& command) {
    return std::system(("cd '" + made.folder.path().string() + "' && openssl cms " + command + " 2>/dev/null").c_str());
  };
  const std::string verify =
      "-verify -binary -inform DER -in face.sig -content face.fbk -CAfile signer.pem -purpose any -out /dev/null";
  CHECK(run(verify) == 0);
  CHECK(run(verify + " -cades") == 0);
  CHECK(run("-sign -binary -in face.fbk -signer signer.pem -inkey key.pem -outform DER -out face.sig") == 0);
  made.signature = read_file(made.folder / "face.sig");
  CHECK(made.check().signer.subject == "CN = Ada");
  write_file(made.folder / "face.fbk", std::string("a fake"));
  CHECK(run(verify) != 0);
  CHECK(run("-sign -binary -keyid -md sha384 -in face.fbk -signer signer.pem -inkey key.pem -outform DER -out "
            "face.sig") == 0);
  made.content = bytes_of("a fake");
  made.signature = read_file(made.folder / "face.sig");
  CHECK(made.check().digest == "SHA-384");
}

}  // namespace test_foreign_signatures
