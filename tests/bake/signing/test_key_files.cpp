// Files of keys and certificates: what signs, what is trusted, and what is neither.
#include "bake/signing/key_files.h"

#include "signing/signed_content.h"

namespace test_key_files {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

struct KeyFolder {
  std::filesystem::path write(const char* name, const std::string& text) const {
    write_file(folder / name, text);
    return folder / name;
  }
  std::string signing_refusal(Status status, const std::string& key, const std::string& certificate = "",
                              const std::optional<std::string>& pass_phrase = {}) const {
    const std::filesystem::path beside = certificate.empty() ? "" : write("certificate.pem", certificate);
    return failure(status, [&] { read_signing_key(write("key.pem", key), beside, pass_phrase); });
  }
  std::string trust_refusal(const std::string& text) const {
    return failure(Status::bad_data, [&] { read_trusted({write("trusted.pem", text)}); });
  }

  Folder folder;
  SigningTestKey signer{new_curve_key(), "Ada"}, other{new_curve_key(), "Bob"};
};

TEST_CASE("an encrypted key opens by its pass phrase, and nobody is asked for one") {
  const KeyFolder files;
  const std::string encrypted = files.signer.key_pem("open sesame") + files.signer.certificate_pem();
  CHECK(read_signing_key(files.write("key.pem", encrypted), "", "open sesame").key != nullptr);
  CHECK(holds(files.signing_refusal(Status::invalid_argument, encrypted),
              "the private key is encrypted, and no pass phrase is given (" + (files.folder / "key.pem").string()));
  for (const std::string& wrong : {std::string("open"), std::string(), std::string(2000, 'x')})
    CHECK(holds(files.signing_refusal(Status::invalid_argument, encrypted, "", wrong),
                "the pass phrase given does not open the private key"));
}

TEST_CASE("the certificate is the key's, in its file or beside it") {
  const KeyFolder files;
  const std::string key = files.signer.key_pem(), own = files.signer.certificate_pem(),
                    others = files.other.certificate_pem();
  for (const auto& [with, beside] :
       {std::pair{key + own, std::string()}, {own + key, ""}, {key, others + own}, {key + others, own}}) {
    const std::filesystem::path certificate = beside.empty() ? "" : files.write("certificate.pem", beside);
    const SigningKey read = read_signing_key(files.write("key.pem", with), certificate, {});
    CHECK(X509_cmp(read.certificate.get(), files.signer.certificate()) == 0);
    CHECK(read.chain.size() == (beside.starts_with(others) ? 1 : 0));
  }
  CHECK(holds(files.signing_refusal(Status::bad_data, key),
              "holds no certificate of its private key, and none is given"));
  CHECK(holds(files.signing_refusal(Status::bad_data, key, others), "holds no certificate of the private key"));
  CHECK(holds(files.signing_refusal(Status::bad_data, own), "holds no private key in PEM"));
  CHECK(holds(files.signing_refusal(Status::bad_data, "key"), "holds no private key in PEM"));
  std::string damaged = key;
  damaged[key.find('\n') + 10] = '!';
  CHECK(holds(files.signing_refusal(Status::bad_data, damaged + own), "holds damaged PEM"));
  CHECK(holds(failure(Status::not_found, [&] { read_signing_key(files.folder / "none.pem", "", {}); }), "none.pem"));
}

TEST_CASE("keys of kinds that do not sign are refused by name") {
  const KeyFolder files;
  const auto refusal_of = [&](EVP_PKEY* key) {
    const SigningTestKey made(key, "Ada");
    return files.signing_refusal(Status::unsupported, made.key_pem() + made.certificate_pem());
  };
  CHECK(holds(refusal_of(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519")),
              "a key of the kind ED25519 does not sign: take P-256, P-384, P-521 or RSA of 2048 bits or more"));
  CHECK(holds(refusal_of(EVP_RSA_gen(1024)), "an RSA key of 1024 bits does not sign: it must have 2048 to 16384"));
  CHECK(holds(refusal_of(EVP_EC_gen("secp256k1")), "a key on the curve secp256k1 does not sign"));
}

TEST_CASE("nothing is signed by a certificate that does not hold today") {
  const KeyFolder files;
  const auto refusal_of = [&](const CertificateOptions& options) {
    const SigningTestKey made(new_curve_key(), "Ada", options);
    const std::filesystem::path key = files.write("key.pem", made.key_pem() + made.certificate_pem());
    return failure(Status::bad_data, [&] { sign_bytes({}, read_signing_key(key, "", {})); });
  };
  CHECK(holds(refusal_of({.first_day = -9, .last_day = -2}),
              "it cannot be signed by CN = Ada, whose certificate has expired"));
  CHECK(holds(refusal_of({.first_day = 2}), "it cannot be signed by CN = Ada, whose certificate is not valid yet on "));
  CHECK(holds(refusal_of({.key_usage = "keyAgreement"}), "is not for signatures"));
}

TEST_CASE("what is trusted are certificates and public keys, and nothing private") {
  const KeyFolder files;
  const std::vector<TrustedFile> read =
      read_trusted({files.write("a.pem", files.signer.certificate_pem() + files.other.public_pem()),
                    files.write("b.pem", files.other.certificate_pem())});
  REQUIRE(read.size() == 2);
  CHECK(read[0].certificates.size() == 1);
  CHECK(read[0].keys.size() == 1);
  CHECK(read[1].certificates.size() == 1);
  CHECK(holds(files.trust_refusal(files.signer.certificate_pem() + files.signer.key_pem()),
              "holds a private key, which none but the signer may have"));
  CHECK(holds(files.trust_refusal("a certificate"), "holds neither a certificate nor a public key in PEM ("));
  CHECK(holds(files.trust_refusal(""), "holds neither a certificate nor a public key"));
  CHECK(holds(files.trust_refusal("-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n"),
              "holds a damaged certificate"));
  CHECK(holds(files.trust_refusal("-----BEGIN PUBLIC KEY-----\nAAAA\n-----END PUBLIC KEY-----\n"),
              "holds a damaged public key"));
  const std::string cut = files.signer.certificate_pem();
  CHECK(holds(files.trust_refusal(cut.substr(0, cut.size() / 2)), "holds damaged PEM"));
}

}  // namespace test_key_files
