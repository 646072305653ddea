#include "bake/signing/signer_certificate.h"

#include <openssl/asn1.h>
#include <openssl/x509v3.h>

#include <array>
#include <ctime>
#include <string_view>

#include "bake/signing/content_digest.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

std::string name_text(const X509_NAME* name) {
  const BioChain out(made(BIO_new(BIO_s_mem()), "writing a name"));
  const unsigned long flags = (XN_FLAG_ONELINE | ASN1_STRFLGS_UTF8_CONVERT) & ~ASN1_STRFLGS_ESC_MSB;
  if (X509_NAME_print_ex(out.get(), name, 0, flags) < 0) succeed(0, "writing a name");
  char* text = nullptr;
  const long size = BIO_get_mem_data(out.get(), &text);
  return size > 0 ? shown(std::string_view(text, static_cast<std::size_t>(size))) : "nobody by name";
}

KeyKind curve_kind(const EVP_PKEY* key) {
  std::array<char, 64> group{};
  EVP_PKEY_get_group_name(key, group.data(), group.size(), nullptr);
  const std::string_view name = group.data();
  if (name == "prime256v1") return {"P-256", EVP_sha256()};
  if (name == "secp384r1") return {"P-384", EVP_sha384()};
  if (name == "secp521r1") return {"P-521", EVP_sha512()};
  fail(Status::unsupported, "a key on the curve %s does not sign: take P-256, P-384, P-521 or RSA of 2048 bits or more",
       name.empty() ? "without a name" : shown(name).c_str());
}

std::tm parts_of(const ASN1_TIME* time) {
  std::tm parts{};
  if (!time || ASN1_TIME_to_tm(time, &parts) != 1)
    fail(Status::bad_data, "a time in it is none: %s", openssl_reason().c_str());
  return parts;
}

}  // namespace

KeyKind key_kind(const EVP_PKEY* key) {
  if (!key) fail(Status::unsupported, "its public key is of no known kind: %s", openssl_reason().c_str());
  if (EVP_PKEY_get_base_id(key) == EVP_PKEY_EC) return curve_kind(key);
  const int bits = EVP_PKEY_get_bits(key);
  if (EVP_PKEY_get_base_id(key) != EVP_PKEY_RSA) {
    const char* name = EVP_PKEY_get0_type_name(key);
    fail(Status::unsupported,
         "a key of the kind %s does not sign: take P-256, P-384, P-521 or RSA of 2048 bits or more",
         name ? shown(name).c_str() : "without a name");
  }
  if (bits < 2048 || bits > 16384)
    fail(Status::unsupported, "an RSA key of %d bits does not sign: it must have 2048 to 16384", bits);
  return {format("RSA %d", bits), EVP_sha256()};
}

CertificateFacts certificate_facts(const X509* certificate) {
  const EVP_PKEY* key = X509_get0_pubkey(certificate);
  CertificateFacts facts;
  facts.key_kind = key_kind(key).name;
  facts.key_sha256 = key_sha256(key);
  facts.subject = subject_of(certificate);
  facts.issuer = name_text(X509_get_issuer_name(certificate));
  facts.valid_from = day_of(X509_get0_notBefore(certificate));
  facts.valid_until = day_of(X509_get0_notAfter(certificate));
  return facts;
}

std::string subject_of(const X509* certificate) {
  return name_text(X509_get_subject_name(certificate));
}

std::string key_sha256(const EVP_PKEY* key) {
  const std::vector<unsigned char> der = der_of(key, i2d_PUBKEY, "writing a public key");
  return sha256_of_bytes(std::as_bytes(std::span(der)));
}

void check_key_usage(const X509* certificate, const char* begin) {
  // All bits are set where the certificate does not limit the use of its key.
  if (X509_get_key_usage(const_cast<X509*>(certificate)) & (KU_DIGITAL_SIGNATURE | KU_NON_REPUDIATION)) return;
  fail(Status::bad_data,
       "%s %s, whose certificate is not for signatures: its key usage has neither digitalSignature nor nonRepudiation",
       begin, subject_of(certificate).c_str());
}

void check_validity(const X509* certificate, const std::string& day, const char* begin) {
  const std::string from = day_of(X509_get0_notBefore(certificate)), until = day_of(X509_get0_notAfter(certificate));
  if (day >= from && day <= until) return;
  fail(Status::bad_data, "%s %s, whose certificate %s %s: it is valid from %s to %s", begin,
       subject_of(certificate).c_str(), day < from ? "is not valid yet on" : "has expired by", day.c_str(),
       from.c_str(), until.c_str());
}

std::string day_of(const ASN1_TIME* time) {
  const std::tm parts = parts_of(time);
  return format("%04d-%02d-%02d", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
}

std::string moment_of(const ASN1_TIME* time) {
  const std::tm parts = parts_of(time);
  return day_of(time) + format("T%02d:%02d:%02dZ", parts.tm_hour, parts.tm_min, parts.tm_sec);
}

}  // namespace fb::bake
