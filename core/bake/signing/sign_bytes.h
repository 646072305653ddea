// Detached signatures over the bytes of a file: CMS SignedData (RFC 5652) in DER, with one signer, whose certificate is
// in it, and signed attributes: digest, signing time, hash of the certificate (ESS signing-certificate-v2, RFC 5035).
//
// Why CMS by OpenSSL, and not Ed25519 by libsodium: an archive is kept for longer than its signer's key. A CMS
// signature names its signer by an X.509 certificate, with dates between which it holds and with who answers for it;
// studios and archives have such certificates. Any `openssl cms -verify` checks it without us, as will whatever reads
// the standard in fifty years. A signature of libsodium is 64 bytes: whose, since when and until when would be a format
// of ours.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/signing/key_files.h"

namespace fb::bake {

// Fails with bad_data, naming the certificate, if it is not valid today or not for signatures.
std::vector<std::byte> sign_bytes(std::span<const std::byte> content, const SigningKey& signer);

}  // namespace fb::bake
