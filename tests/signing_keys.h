// Keys and certificates for tests, made when they run.
#pragma once

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace fb::test {

struct CertificateOptions {
  int first_day = -1, last_day = 3650;  // from now
  const char* constraints = "critical,CA:FALSE";
  const char* key_usage = nullptr;
};

// A private key, and a certificate of it by itself or by another one.
class SigningTestKey {
 public:
  explicit SigningTestKey(EVP_PKEY* key, const std::string& name = "Ada", const CertificateOptions& options = {},
                          const SigningTestKey* issuer = nullptr)
      : key_(key, EVP_PKEY_free), certificate_(X509_new(), X509_free) {
    static long serial = 1;
    X509* const made = certificate_.get();
    X509_set_version(made, X509_VERSION_3);
    ASN1_INTEGER_set(X509_get_serialNumber(made), serial++);
    X509_time_adj_ex(X509_getm_notBefore(made), options.first_day, 0, nullptr);
    X509_time_adj_ex(X509_getm_notAfter(made), options.last_day, 0, nullptr);
    X509_set_pubkey(made, key);
    X509_NAME_add_entry_by_txt(X509_get_subject_name(made), "CN", MBSTRING_UTF8,
                               reinterpret_cast<const unsigned char*>(name.data()), static_cast<int>(name.size()), -1,
                               0);
    const SigningTestKey& by = issuer ? *issuer : *this;
    X509_set_issuer_name(made, X509_get_subject_name(by.certificate_.get()));
    add_extension(NID_subject_key_identifier, "hash");
    add_extension(NID_basic_constraints, options.constraints);
    if (options.key_usage) add_extension(NID_key_usage, options.key_usage);
    const bool own_digest = EVP_PKEY_get_base_id(by.key_.get()) == EVP_PKEY_ED25519;
    if (X509_sign(made, by.key_.get(), own_digest ? nullptr : EVP_sha256()) <= 0)
      throw std::runtime_error("no certificate");
  }

  EVP_PKEY* key() const { return key_.get(); }
  X509* certificate() const { return certificate_.get(); }

  std::string key_pem(const char* pass_phrase = nullptr) const {
    return pem([&](BIO* out) {
      PEM_write_bio_PKCS8PrivateKey(out, key_.get(), pass_phrase ? EVP_aes_256_cbc() : nullptr, pass_phrase,
                                    pass_phrase ? static_cast<int>(std::string(pass_phrase).size()) : 0, nullptr,
                                    nullptr);
    });
  }
  std::string certificate_pem() const {
    return pem([&](BIO* out) { PEM_write_bio_X509(out, certificate_.get()); });
  }
  std::string public_pem() const {
    return pem([&](BIO* out) { PEM_write_bio_PUBKEY(out, key_.get()); });
  }

 private:
  void add_extension(int kind, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx(&context, nullptr, certificate_.get(), nullptr, nullptr, 0);
    const std::unique_ptr<X509_EXTENSION, void (*)(X509_EXTENSION*)> one(
        X509V3_EXT_conf_nid(nullptr, &context, kind, value), X509_EXTENSION_free);
    X509_add_ext(certificate_.get(), one.get(), -1);
  }

  template <class Write>
  static std::string pem(Write&& write) {
    const std::unique_ptr<BIO, int (*)(BIO*)> out(BIO_new(BIO_s_mem()), BIO_free);
    write(out.get());
    char* text = nullptr;
    const long size = BIO_get_mem_data(out.get(), &text);
    return {text, static_cast<std::size_t>(size)};
  }

  std::unique_ptr<EVP_PKEY, void (*)(EVP_PKEY*)> key_;
  std::unique_ptr<X509, void (*)(X509*)> certificate_;
};

inline EVP_PKEY* new_curve_key(const char* curve = "P-256") {
  return EVP_EC_gen(curve);
}

}  // namespace fb::test
