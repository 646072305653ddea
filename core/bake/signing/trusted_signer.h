// By which of the trusted certificates and keys a signer is known.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/signing/cms_signature.h"
#include "bake/signing/key_files.h"

namespace fb::bake {

enum class TrustedBy { certificate, public_key, issuer };

struct TrustFound {
  std::filesystem::path file;
  TrustedBy by = TrustedBy::certificate;
  std::string trusted;  // the subject of what is trusted; of a public key its SHA-256
  // Who issued the signer's certificate, and so on, up to the one that is trusted; of the files or of the signature.
  std::vector<CertificatePointer> issuers;
};

// The first file that has the signer's certificate or public key, or the certificate of who issued it, of whatever
// length the chain is; validity by dates is not looked at. Fails with bad_data: who the signer is, and who is trusted.
TrustFound find_trust(const CmsSignature& signature, std::span<const TrustedFile> trusted);

}  // namespace fb::bake
