#include "bake/signing/consent.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/rig/json_field.h"
#include "bake/signing/content_digest.h"
#include "bake/signing/signed_document.h"
#include "base/calendar_day.h"
#include "base/file.h"
#include "base/shown_path.h"

namespace fb::bake {

bool Consent::permits_use(std::string_view use) const {
  return std::ranges::find(permits, use) != permits.end();
}

Consent parse_consent(std::string_view text, const std::string& place) {
  const auto json = parse_json<nlohmann::json>(text, place);
  const JsonField root(json, place + ":");
  check_document(root, "facebaker-consent");
  Consent consent;
  consent.performer = root["performer"].nonempty_text();
  consent.agreement = root["agreement"].nonempty_text();
  for (const JsonField& use : root["permits"].nonempty_items()) consent.permits.push_back(use.nonempty_text());
  consent.expires = day_or_none(root["expires"]);
  for (const JsonField& source : root["sources"].items_or_none())
    consent.sources.push_back(sha256_in(source["sha256"]));
  return consent;
}

Consent verified_consent(const std::filesystem::path& file, const std::filesystem::path& key, const std::string& day) {
  const std::vector<std::byte> bytes = read_file(file, most_document_bytes);
  const SignatureFacts signature =
      check_signature_file(bytes, signature_beside(file), read_trusted({key}), SignatureRules{.day = day});
  Consent consent = parse_consent(text_of(bytes), shown(file));
  if (!consent.expires.empty() && day > consent.expires)
    fail_on(file, Status::bad_data,
            format("the consent of %s has expired: it held until %s, and this is %s", shown(consent.performer).c_str(),
                   consent.expires.c_str(), day.c_str()));
  consent.sha256 = sha256_of_bytes(bytes);
  consent.signature = signature;
  return consent;
}

}  // namespace fb::bake
