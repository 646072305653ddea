// Whether a detached signature (sign_bytes.h) is one over these bytes, by somebody who is trusted.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bake/signing/key_files.h"
#include "bake/signing/signer_certificate.h"
#include "bake/signing/trusted_signer.h"

namespace fb::bake {

struct SignatureRules {
  std::string day;  // that it must hold on
  bool accept_expired =
      false;  // a certificate that was valid on the day that the signer says to have signed on is enough
};

struct SignatureFacts {
  CertificateFacts signer;
  std::string signed_at;  // "2031-12-31T23:59:59Z": the signer's word; nothing proves it
  std::string digest;     // "SHA-256"
  std::filesystem::path trusted_file;
  TrustedBy trusted_by = TrustedBy::certificate;
  std::string trusted;   // see TrustFound
  bool expired = false;  // the certificate, on that day; accept_expired let it pass
};

// All of: it is one CMS SignedData in DER and nothing more, over bytes beside it, with one signer, whose certificate is
// in it and may sign; its digest and algorithm are known ones; it signs these bytes; `trusted` has the certificate or
// its public key, or who issued it; it was signed before rules.day ends, on a day when the certificate was valid; and
// the certificate is valid on rules.day. Fails with bad_data or unsupported: what is not so, in the order above, as
// what "is" or "has" of a signature. Reads no network and no store of the system's.
SignatureFacts check_signature(std::span<const std::byte> content, std::span<const std::byte> signature,
                               std::span<const TrustedFile> trusted, const SignatureRules& rules);

// Of a file and the signature of it in another; failures name the latter.
SignatureFacts check_signature_file(std::span<const std::byte> content, const std::filesystem::path& signature,
                                    std::span<const TrustedFile> trusted, const SignatureRules& rules);

// "FILE.sig", where the signature of a file is unless told otherwise.
std::filesystem::path signature_beside(const std::filesystem::path& file);

}  // namespace fb::bake
