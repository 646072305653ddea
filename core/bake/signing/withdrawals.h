// Lists of consents that were withdrawn: a dated JSON file with a signature beside it, FILE.sig, which reaches archives
// that are out. docs/archivists.md has the format.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bake/signing/check_signature.h"

namespace fb::bake {

struct Withdrawal {
  std::string agreement, sha256;  // what is withdrawn: all archives under the agreement, or one; either may be ""
  std::string since, reason;      // the first day on which it is, and why
};

struct WithdrawalList {
  std::filesystem::path file;
  std::string issued;      // day
  std::string next_issue;  // the day by which a newer list is due; "" if none is promised
  std::vector<Withdrawal> withdrawals;
  SignatureFacts signature;
};

// Fails with bad_data, naming `place`, field and fault, and with unsupported on a later version.
WithdrawalList parse_withdrawals(std::string_view text, const std::string& place);

// The list of a file that is signed by somebody trusted, and in force on rules.day: not issued later, and no newer one
// is due. Fails with the path: not_found, io, bad_data or unsupported.
WithdrawalList verified_withdrawals(const std::filesystem::path& file, std::span<const TrustedFile> trusted,
                                    const SignatureRules& rules);

// Fails with bad_data if the list withdraws the agreement ("" if there is none) or the archive with that SHA-256 on
// that day: since when, why, by which list and by whom. Gives sentences on withdrawals that begin later.
std::vector<std::string> check_not_withdrawn(const WithdrawalList& list, const std::string& agreement,
                                             const std::string& sha256, const std::string& day);

}  // namespace fb::bake
