// Certificates of those who sign, and their public keys: what they are, as people read it.
#pragma once

#include <string>

#include "bake/signing/openssl_objects.h"

namespace fb::bake {

// What can sign: RSA of 2048 to 16384 bits, or one of the curves P-256, P-384 and P-521. Ed25519 is none of them, as
// OpenSSL 3.0 has no CMS with it (RFC 8419).
struct KeyKind {
  std::string name;      // "RSA 3072", "P-256"
  const EVP_MD* digest;  // that it signs with: SHA-256, of the larger curves SHA-384 and SHA-512
};

// Fails with unsupported, naming the kind, on every other key.
KeyKind key_kind(const EVP_PKEY* key);

struct CertificateFacts {
  std::string subject, issuer;  // "CN = Studio, O = Films"
  std::string key_kind;
  std::string key_sha256;               // of the public key in DER (SubjectPublicKeyInfo), as 64 hexadecimal digits
  std::string valid_from, valid_until;  // days, both included
};

// Fails as key_kind does.
CertificateFacts certificate_facts(const X509* certificate);

std::string subject_of(const X509* certificate);
std::string key_sha256(const EVP_PKEY* key);

// Fail with bad_data if the certificate may not sign documents (its key usage), or is not valid on that day: "`begin`
// CN = Studio, whose certificate has expired by 2031-12-31: ...".
void check_key_usage(const X509* certificate, const char* begin);
void check_validity(const X509* certificate, const std::string& day, const char* begin);

// "2031-12-31", and with the time of the day "2031-12-31T23:59:59Z". Fails with bad_data where it is no time.
std::string day_of(const ASN1_TIME* time);
std::string moment_of(const ASN1_TIME* time);

}  // namespace fb::bake
