#include "bake/signing/sign_file.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bake/rig/json_field.h"
#include "bake/signing/consent.h"
#include "bake/signing/sign_bytes.h"
#include "bake/signing/signed_document.h"
#include "bake/signing/withdrawals.h"
#include "base/calendar_day.h"
#include "base/file.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

void check_output(const std::filesystem::path& file, const SigningFiles& files) {
  for (const std::filesystem::path& input : {file, files.key, files.certificate}) {
    std::error_code missing;
    if (!input.empty() && (input == files.signature || std::filesystem::equivalent(input, files.signature, missing)))
      fail_on(files.signature, Status::invalid_argument, "the signature would replace " + shown(input));
  }
}

// Mistakes in what others will read are found before it is signed.
void check_document_file(const std::filesystem::path& file, std::span<const std::byte> content) {
  const std::string_view text = text_of(content);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == text.npos || text[begin] != '{' || text.size() > most_document_bytes) return;
  const nlohmann::ordered_json object = object_in(text);
  if (!object.is_object() || !object.contains("format")) return;
  if (object["format"] == "facebaker-consent") parse_consent(text, shown(file));
  if (object["format"] == "facebaker-withdrawals") parse_withdrawals(text, shown(file));
}

}  // namespace

SignatureFacts sign_file(const std::filesystem::path& file, std::span<const std::byte> content,
                         const SigningFiles& files) {
  check_output(file, files);
  check_document_file(file, content);
  SigningKey signer = read_signing_key(files.key, files.certificate, files.pass_phrase);
  const std::vector<std::byte> signature = with_path(file, [&] { return sign_bytes(content, signer); });
  std::array<TrustedFile, 1> own;
  own[0].path = files.certificate.empty() ? files.key : files.certificate;
  own[0].certificates.push_back(std::move(signer.certificate));
  // The day of the signature itself: midnight may have passed.
  SignatureFacts facts =
      check_signature(content, signature, own, {.day = calendar_day_text(today()), .accept_expired = true});
  write_file(files.signature, signature);
  return facts;
}

}  // namespace fb::bake
