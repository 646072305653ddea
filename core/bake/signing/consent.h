// A performer's consent: a JSON file with a signature beside it, FILE.sig. FORMAT: docs/archivists.md, "A consent".
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bake/signing/check_signature.h"

namespace fb::bake {

struct Consent {
  std::string performer, agreement;
  std::vector<std::string> permits;  // uses in words; "learning": that networks may be trained
  std::string expires;               // the last day on which it holds; "" if it does not end
  std::vector<std::string> sources;  // SHA-256 of the files that it is about, in lower case; none: of whatever is
                                     // the agreement's
  std::string sha256;                // of the file itself
  SignatureFacts signature;

  bool permits_use(std::string_view use) const;
};

// Fails with bad_data, naming `place`, field and fault, on what is no consent, and with unsupported on a later
// version.
Consent parse_consent(std::string_view text, const std::string& place);

// The consent of a file whose signature, FILE.sig, is by `key`, a PEM file with a certificate or public key (what is
// trusted: see check_signature), and which holds on that day. Fails with the paths: not_found, io, bad_data or
// unsupported.
Consent verified_consent(const std::filesystem::path& file, const std::filesystem::path& key, const std::string& day);

}  // namespace fb::bake
