#include "bake/signing/check_signature.h"

#include "base/file.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

void check_signed_day(const CmsSignature& signature, const SignatureRules& rules) {
  const std::string day = signature.signed_day();
  if (day > rules.day)
    fail(Status::bad_data, "says that it was signed at %s, which is after %s", signature.signed_at().c_str(),
         rules.day.c_str());
  check_validity(signature.certificate(), day, "says that it was signed by");
}

// Whether the certificate has expired, which rules.accept_expired lets pass.
bool check_days(const CmsSignature& signature, const TrustFound& trust, const SignatureRules& rules) {
  check_signed_day(signature, rules);
  const std::string day = signature.signed_day();
  const bool expired = rules.day > day_of(X509_get0_notAfter(signature.certificate()));
  const std::string& judged = rules.accept_expired ? day : rules.day;
  try {
    check_validity(signature.certificate(), judged, "is by");
    for (const CertificatePointer& one : trust.issuers) check_validity(one.get(), judged, "is by a certificate of");
  } catch (const Error& error) {
    if (!expired || rules.accept_expired) throw;
    fail(Status::bad_data,
         "%s; it was valid at %s, when the signer says to have signed (accept that by --accept-expired)", error.what(),
         signature.signed_at().c_str());
  }
  return expired;
}

}  // namespace

SignatureFacts check_signature(std::span<const std::byte> content, std::span<const std::byte> signature,
                               std::span<const TrustedFile> trusted, const SignatureRules& rules) {
  const CmsSignature read(signature);
  read.check_content(content);
  const TrustFound trust = find_trust(read, trusted);
  SignatureFacts facts;
  facts.expired = check_days(read, trust, rules);
  facts.signer = certificate_facts(read.certificate());
  facts.signed_at = read.signed_at();
  facts.digest = read.digest();
  facts.trusted_file = trust.file;
  facts.trusted_by = trust.by;
  facts.trusted = trust.trusted;
  return facts;
}

SignatureFacts check_signature_file(std::span<const std::byte> content, const std::filesystem::path& signature,
                                    std::span<const TrustedFile> trusted, const SignatureRules& rules) {
  const std::vector<std::byte> der = read_file(signature, most_signature_bytes);
  try {
    return check_signature(content, der, trusted, rules);
  } catch (const Error& error) {
    fail_on(signature, error.status(), std::string("the signature ") + error.what());
  }
}

std::filesystem::path signature_beside(const std::filesystem::path& file) {
  std::filesystem::path path = file;
  path += ".sig";
  return path;
}

}  // namespace fb::bake
