#include <facebaker/facebaker_sign.h>

#include <nlohmann/json.hpp>

#include "archive/container/container_layout.h"
#include "bake/authoring.h"
#include "bake/measure/verify.h"
#include "bake/rights/rights.h"
#include "bake/signing/content_digest.h"
#include "bake/signing/sign_file.h"
#include "bake/signing/withdrawals.h"
#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

using Json = nlohmann::ordered_json;
using fb::bake::SignatureFacts;
using Paths = std::vector<std::filesystem::path>;

// By its first bytes or its name: the former may be damaged.
bool is_archive(const std::string& path, std::span<const std::byte> bytes) {
  constexpr std::size_t begin = 4;
  return fb::file_extension(path) == ".fbk" ||
         (bytes.size() >= begin && std::memcmp(bytes.data(), fb::archive::archive_signature, begin) == 0);
}

Json signer_json(const SignatureFacts& facts) {
  return {{"subject", facts.signer.subject},
          {"issuer", facts.signer.issuer},
          {"key", facts.signer.key_kind},
          {"key_sha256", facts.signer.key_sha256},
          {"valid_from", facts.signer.valid_from},
          {"valid_until", facts.signer.valid_until},
          {"expired", facts.expired}};
}

Json trust_json(const SignatureFacts& facts) {
  static constexpr const char* kinds[] = {"certificate", "public key", "issuer"};
  return {{"by", kinds[static_cast<std::size_t>(facts.trusted_by)]},
          {"name", facts.trusted},
          {"file", facts.trusted_file.string()}};
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

// What a file is, and what of it is signed.
struct SignedFile {
  std::string name;
  std::span<const std::byte> bytes;
  std::string agreement;  // of an archive's rights; "" if there is none
};

std::string agreement_in(const fb::archive::Archive& archive) {
  return fb::bake::rights_in(archive.model.character.about).agreement;
}

Paths paths_of(const char* const* paths, std::uint32_t count, const char* field) {
  Paths list;
  for (std::uint32_t i = 0; i < count; ++i) {
    require(paths, field);
    require(paths[i], field);
    list.emplace_back(paths[i]);
  }
  return list;
}

// Refuses what is withdrawn; gives what the lists are, and adds notes.
Json check_lists(const SignedFile& file, const std::string& sha256, const std::string& signed_at, const Paths& lists,
                 std::span<const fb::bake::TrustedFile> trusted, const fb::bake::SignatureRules& rules, Json& notes) {
  Json documents = Json::array();
  for (const std::filesystem::path& path : lists) {
    const fb::bake::WithdrawalList list = fb::bake::verified_withdrawals(path, trusted, rules);
    for (std::string& later : fb::bake::check_not_withdrawn(list, file.agreement, sha256, rules.day))
      notes.push_back(std::move(later));
    if (list.issued < signed_at.substr(0, list.issued.size()))
      notes.push_back("the list of withdrawals of " + list.issued + " is older than the signature of " + signed_at +
                      " (" + fb::shown(path) + ")");
    documents.push_back({{"file", path.string()},
                         {"issued", list.issued},
                         {"next_issue", text_or_null(list.next_issue)},
                         {"entries", list.withdrawals.size()},
                         {"signed_by", list.signature.signer.subject},
                         {"signed_at", list.signature.signed_at}});
  }
  return documents;
}

std::string verify_document(const SignedFile& file, const fb_verify_signature_desc& desc) {
  const std::filesystem::path signature =
      desc.signature ? std::filesystem::path(desc.signature) : fb::bake::signature_beside(file.name);
  const std::vector<fb::bake::TrustedFile> trusted =
      fb::bake::read_trusted(paths_of(desc.trusted, desc.trusted_count, "fb_verify_signature_desc: trusted"));
  const fb::bake::SignatureRules rules = {fb::calendar_day_text(day_of(desc.on)),
                                          (desc.flags & FB_SIGNATURE_ACCEPT_EXPIRED) != 0};
  const SignatureFacts facts = fb::bake::check_signature_file(file.bytes, signature, trusted, rules);
  const std::string sha256 = fb::bake::sha256_of_bytes(file.bytes);
  Json notes = Json::array();
  const Json lists = check_lists(file, sha256, facts.signed_at,
                                 paths_of(desc.withdrawn, desc.withdrawn_count, "fb_verify_signature_desc: withdrawn"),
                                 trusted, rules, notes);
  return json_text({{"file", file.name},
                    {"sha256", sha256},
                    {"signature", signature.string()},
                    {"on", rules.day},
                    {"signed_at", facts.signed_at},
                    {"digest", facts.digest},
                    {"signer", signer_json(facts)},
                    {"trusted", trust_json(facts)},
                    {"agreement", text_or_null(file.agreement)},
                    {"withdrawn", lists},
                    {"notes", notes}});
}

void check_archive(const std::string& path, std::span<const std::byte> bytes) {
  if (is_archive(path, bytes)) fb::with_path(std::filesystem::path(path), [&] { fb::bake::verify_archive(bytes); });
}

}  // namespace

extern "C" {

void fb_sign_desc_fill(fb_sign_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_sign(const fb_sign_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_sign_desc known = read_struct(*desc, fb_sign_desc_init, "fb_sign_desc");
    require(known.path, "fb_sign_desc: path");
    require(known.key, "fb_sign_desc: key");
    fb::bake::SigningFiles files = {known.key, text_or_empty(known.certificate), std::nullopt,
                                    fb::bake::signature_beside(known.path)};
    if (known.pass_phrase) files.pass_phrase = known.pass_phrase;
    if (known.signature) files.signature = known.signature;
    const std::vector<std::byte> bytes = fb::read_file(known.path);
    check_archive(known.path, bytes);
    const SignatureFacts facts = fb::bake::sign_file(known.path, bytes, files);
    auto made = std::make_unique<fb_report>();
    made->json = json_text({{"file", known.path},
                            {"sha256", fb::bake::sha256_of_bytes(bytes)},
                            {"signature", files.signature.string()},
                            {"signed_at", facts.signed_at},
                            {"digest", facts.digest},
                            {"signer", signer_json(facts)}});
    hand_over(std::move(made), report);
  });
}

void fb_verify_signature_desc_fill(fb_verify_signature_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_verify_signature(const fb_verify_signature_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const auto known = read_struct(*desc, fb_verify_signature_desc_init, "fb_verify_signature_desc");
    if (known.flags & ~FB_SIGNATURE_ACCEPT_EXPIRED)
      fail(Status::invalid_argument, "fb_verify_signature_desc: flags has bits that are no flag of it");
    auto made = std::make_unique<fb_report>();
    if (known.archive) {
      const fb_archive& archive = *known.archive;
      made->json = verify_document({archive.name, archive.bytes, agreement_in(archive.contents)}, known);
    } else {
      require(known.path, "fb_verify_signature_desc: path");
      const std::vector<std::byte> bytes = fb::read_file(known.path);
      SignedFile file = {known.path, bytes, ""};
      if (is_archive(known.path, bytes))
        file.agreement = fb::with_path(std::filesystem::path(known.path),
                                       [&] { return agreement_in(fb::archive::read_archive(bytes)); });
      made->json = verify_document(file, known);
    }
    hand_over(std::move(made), report);
  });
}

}  // extern "C"
