#include "bake/signing/withdrawals.h"

#include <nlohmann/json.hpp>

#include "bake/rig/json_field.h"
#include "bake/signing/signed_document.h"
#include "base/file.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

Withdrawal withdrawal_in(const JsonField& entry) {
  Withdrawal found;
  if (entry["agreement"].exists()) found.agreement = entry["agreement"].nonempty_text();
  if (entry["sha256"].exists()) found.sha256 = sha256_in(entry["sha256"]);
  if (found.agreement.empty() && found.sha256.empty()) entry.refuse("names neither an agreement nor a sha256");
  found.since = day_in(entry["since"]);
  found.reason = entry["reason"].nonempty_text();
  return found;
}

bool concerns(const Withdrawal& one, const std::string& agreement, const std::string& sha256) {
  return (!agreement.empty() && one.agreement == agreement) || one.sha256 == sha256;
}

// "the consent of agreement A-7" or "the consent for this archive".
std::string what_is_withdrawn(const Withdrawal& one, const std::string& agreement) {
  if (!agreement.empty() && one.agreement == agreement) return "the consent of agreement " + shown(agreement);
  return "the consent for the archive with the SHA-256 " + one.sha256;
}

void check_dates(const WithdrawalList& list, const std::string& day) {
  if (list.issued > day)
    fail(Status::bad_data, "the list of withdrawals was issued on %s, which is after %s", list.issued.c_str(),
         day.c_str());
  if (!list.next_issue.empty() && day > list.next_issue)
    fail(Status::bad_data, "the list of withdrawals of %s is out of date: a newer one was due by %s, and this is %s",
         list.issued.c_str(), list.next_issue.c_str(), day.c_str());
}

}  // namespace

WithdrawalList parse_withdrawals(std::string_view text, const std::string& place) {
  const auto json = parse_json<nlohmann::json>(text, place);
  const JsonField root(json, place + ":");
  check_document(root, "facebaker-withdrawals");
  WithdrawalList list;
  list.issued = day_in(root["issued"]);
  list.next_issue = day_or_none(root["next_issue"]);
  if (!list.next_issue.empty() && list.next_issue < list.issued)
    root["next_issue"].refuse("is " + list.next_issue + ", before it was issued");
  for (const JsonField& entry : root["withdrawn"].items()) list.withdrawals.push_back(withdrawal_in(entry));
  return list;
}

WithdrawalList verified_withdrawals(const std::filesystem::path& file, std::span<const TrustedFile> trusted,
                                    const SignatureRules& rules) {
  const std::vector<std::byte> bytes = read_file(file, most_document_bytes);
  const SignatureFacts signature = check_signature_file(bytes, signature_beside(file), trusted, rules);
  WithdrawalList list = parse_withdrawals(text_of(bytes), shown(file));
  with_path(file, [&] { check_dates(list, rules.day); });
  list.file = file;
  list.signature = signature;
  return list;
}

std::vector<std::string> check_not_withdrawn(const WithdrawalList& list, const std::string& agreement,
                                             const std::string& sha256, const std::string& day) {
  std::vector<std::string> later;
  for (const Withdrawal& one : list.withdrawals) {
    if (!concerns(one, agreement, sha256)) continue;
    const std::string what = what_is_withdrawn(one, agreement);
    if (one.since > day) {
      later.push_back(
          format("%s will be withdrawn on %s: %s", what.c_str(), one.since.c_str(), shown(one.reason).c_str()));
      continue;
    }
    fail_on(list.file, Status::bad_data,
            format("%s is withdrawn since %s: %s, says the list of %s by %s", what.c_str(), one.since.c_str(),
                   shown(one.reason).c_str(), list.issued.c_str(), list.signature.signer.subject.c_str()));
  }
  return later;
}

}  // namespace fb::bake
