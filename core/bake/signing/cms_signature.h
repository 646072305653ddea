// A CMS signature as it was read: its one signer, and whether it signs some bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bake/signing/openssl_objects.h"

namespace fb::bake {

inline constexpr std::size_t most_signature_bytes = 1 << 20;

class CmsSignature {
 public:
  // Fails with bad_data or unsupported as check_signature does, as far as nothing but the signature is needed for it.
  explicit CmsSignature(std::span<const std::byte> der);

  const X509* certificate() const { return certificate_; }
  // All certificates that are in it, the signer's too.
  const STACK_OF(X509) * certificates() const { return certificates_.get(); }
  std::string signed_at() const;
  std::string signed_day() const;
  std::string digest() const;  // "SHA-256"

  // Fails with bad_data unless it is the signature of these bytes by the certificate's key.
  void check_content(std::span<const std::byte> content) const;

 private:
  struct FreeCertificates {
    void operator()(STACK_OF(X509) * stack) const { sk_X509_pop_free(stack, X509_free); }
  };

  void find_signer();
  void check_frame(std::span<const std::byte> der) const;
  void check_algorithms() const;
  void check_attributes() const;
  const ASN1_TIME* signing_time() const;

  CmsMessage message_;
  std::unique_ptr<STACK_OF(X509), FreeCertificates> certificates_;
  CMS_SignerInfo* signer_ = nullptr;  // of message_
  X509* certificate_ = nullptr;       // of certificates_
};

}  // namespace fb::bake
