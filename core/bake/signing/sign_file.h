// Signing a file, as a whole: its signature appears beside it, and is checked before.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "bake/signing/check_signature.h"

namespace fb::bake {

struct SigningFiles {
  std::filesystem::path key, certificate;  // certificate may be "": it is in the key's file
  std::optional<std::string> pass_phrase;
  std::filesystem::path signature;  // to write
};

// Signs the bytes of `file` and gives what the signature says. A consent or a list of withdrawals, by its "format",
// must be a whole one. Fails as read_signing_key, sign_bytes and write_file do, and with invalid_argument where the
// signature would replace the file, the key or the certificate.
SignatureFacts sign_file(const std::filesystem::path& file, std::span<const std::byte> content,
                         const SigningFiles& files);

}  // namespace fb::bake
