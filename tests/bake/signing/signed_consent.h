// A consent with a signature beside it, for tests.
#pragma once

#include <filesystem>
#include <string>

#include "bake/signing/consent.h"
#include "bake/signing/sign_bytes.h"
#include "bake_test_support.h"
#include "base/calendar_day.h"
#include "base/file.h"
#include "signing_keys.h"

namespace fb::test {

struct SignedConsent {
  explicit SignedConsent(const std::string& text) {
    write_file(file, text);
    write_file(folder / "key.pem", signer.key_pem() + signer.certificate_pem());
    write_file(key, signer.public_pem());
    write_file(folder / "consent.json.sig",
               bake::sign_bytes(read_file(file), bake::read_signing_key(folder / "key.pem", "", {})));
  }

  std::string refusal(Status status = Status::bad_data, const std::string& day = calendar_day_text(today())) const {
    return failure(status, [&] { bake::verified_consent(file, key, day); });
  }

  Folder folder;
  SigningTestKey signer{new_curve_key(), "Ada's agent"};
  std::filesystem::path file = folder / "consent.json", key = folder / "agent.pem";
};

}  // namespace fb::test
