// What the tests of signatures share: some bytes, signed.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bake/signing/check_signature.h"
#include "bake/signing/sign_bytes.h"
#include "bake_test_support.h"
#include "base/calendar_day.h"
#include "signing_keys.h"

namespace fb::test {

inline std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline std::string day_from_now(int days) {
  return calendar_day_text(today() + std::chrono::days(days));
}
inline std::string this_day() {
  return day_from_now(0);
}

// In a folder: "key.pem" with the certificate, "signer.pem" with the certificate alone, which is trusted.
struct SignedContent {
  explicit SignedContent(SigningTestKey given) : signer(std::move(given)) {
    write_file(folder / "key.pem", signer.key_pem() + signer.certificate_pem());
    trust(signer.certificate_pem());
    signature = bake::sign_bytes(content, bake::read_signing_key(folder / "key.pem", "", {}));
  }

  void trust(const std::string& pem) const { write_file(folder / "signer.pem", pem); }
  bake::SignatureFacts check(const bake::SignatureRules& rules = {.day = this_day()}) const {
    return bake::check_signature(content, signature, bake::read_trusted({folder / "signer.pem"}), rules);
  }
  std::string refusal(const bake::SignatureRules& rules = {.day = this_day()}, Status status = Status::bad_data) const {
    return failure(status, [&] { check(rules); });
  }

  Folder folder;
  SigningTestKey signer;
  std::vector<std::byte> content = bytes_of("a face"), signature;
};

}  // namespace fb::test
