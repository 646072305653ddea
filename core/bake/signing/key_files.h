// Keys and certificates in PEM files: what signs, and what is trusted.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/signing/openssl_objects.h"

namespace fb::bake {

struct SigningKey {
  KeyPointer key;
  CertificatePointer certificate;         // of the key
  std::vector<CertificatePointer> chain;  // others that were given, of those who issued it
};

// The private key of a file and its certificate, which may be in the same file where `certificate` is empty. A key that
// is encrypted needs its pass phrase; nobody is asked for one. Fails with the path: not_found, io, bad_data where there
// is no key or no certificate of it, unsupported on a kind of key that does not sign.
SigningKey read_signing_key(const std::filesystem::path& key, const std::filesystem::path& certificate,
                            const std::optional<std::string>& pass_phrase);

// What one file of trusted PEM has: certificates, of signers or of those who issue theirs, and public keys.
struct TrustedFile {
  std::filesystem::path path;
  std::vector<CertificatePointer> certificates;
  std::vector<KeyPointer> keys;
};

// Fails with the path where there are neither, and where there is a private key, which is for no others to have.
std::vector<TrustedFile> read_trusted(const std::vector<std::filesystem::path>& paths);

}  // namespace fb::bake
