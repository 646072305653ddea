#include "bake/pipeline/leave_to_learn.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/pipeline/recipe_table.h"
#include "bake/rig/about.h"
#include "bake/rights/binding_rights.h"
#include "bake/rights/rights.h"
#include "base/calendar_day.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr const char* untrained = "untrained";

// "learning from it is forbidden (ai_training: notAllowed)".
std::string why_forbidden(const Rights& rights) {
  for (const std::string& clause : binding_rights(rights, today()))
    if (clause.starts_with("learning ")) return clause;
  return "learning from it is forbidden";
}

[[noreturn]] void refuse(const BakeOptions& options, const std::string& why) {
  fail(Status::invalid_argument, "consent %s %s", shown(options.consent).c_str(), why.c_str());
}

// That a consent is about this character, and not about another.
void check_subject(const Consent& consent, const Rights& rights, const BakeOptions& options) {
  const auto same = [&](const char* what, const std::string& stated, const std::string& agreed) {
    if (!stated.empty() && stated != agreed)
      refuse(options, format("is about another character: its %s is \"%s\", the character's is \"%s\"", what,
                             agreed.c_str(), stated.c_str()));
  };
  same("agreement", rights.agreement, consent.agreement);
  same("performer", rights.performer, consent.performer);
  if (consent.sources.empty() && rights.agreement.empty())
    refuse(options, "names no source, and the rights of the character no agreement: it may be about another character");
  if (consent.sources.empty()) return;
  for (const SourceFile& file : options.source_files)
    if (std::find(consent.sources.begin(), consent.sources.end(), file.sha256) == consent.sources.end())
      refuse(options, format("is not about \"%s\": none of its sources has the SHA-256 %s", file.name.c_str(),
                             file.sha256.c_str()));
  if (options.source_files.empty()) refuse(options, "names sources, and this source has no file");
}

std::optional<Consent> checked_consent(const Rights& rights, const BakeOptions& options) {
  if (options.consent.empty() != options.consent_key.empty())
    fail(Status::invalid_argument, "%s: both are needed, a consent and the key that it must be signed by",
         options.consent.empty() ? "consent_key without consent" : "consent without consent_key");
  if (options.consent.empty()) return std::nullopt;
  const auto path = [](const std::string& text) {
    return std::filesystem::path(reinterpret_cast<const char8_t*>(text.c_str()));
  };
  Consent consent = verified_consent(path(options.consent), path(options.consent_key), calendar_day_text(today()));
  check_subject(consent, rights, options);
  if (!consent.permits_use("learning")) refuse(options, "does not permit \"learning\"");
  return consent;
}

}  // namespace

std::string about_with(const Source& source, const BakeOptions& options) {
  const std::string& own = source.character().about;
  std::string about = merged_about(own, options.about);
  if (forbids_learning(own) && !forbids_learning(about))
    fail(Status::invalid_argument,
         "about: rights: \"%s\" forbids learning from it, and what is given in its place does not: the stricter holds",
         source.schema().name.c_str());
  return about;
}

std::optional<Consent> leave_to_learn(const std::vector<std::string>& recipes, const Source& source,
                                      const std::string& about, const BakeOptions& options, Progress& progress) {
  const Rights rights = rights_in(about);
  if (rights.expired(today()))
    progress.note(format("warning: the rights of \"%s\" ended on %s", source.schema().name.c_str(),
                         calendar_day_text(*rights.last_day()).c_str()));
  std::optional<Consent> consent = checked_consent(rights, options);
  for (const std::string& recipe : recipes) {
    if (!learns(find_recipe(recipe), source.live())) continue;
    const Permission permission = rights.learning_permission();
    const char* const name = source.schema().name.c_str();
    if (permission == Permission::constrained)
      progress.note(format("\"%s\" may be learned from within constraints (about: rights): %s", name,
                           (rights.constraint_info.empty() ? rights.learning : rights.constraint_info).c_str()));
    if (permission == Permission::not_allowed && !consent)
      fail(Status::invalid_argument,
           "\"%s\": %s, and the recipe \"%s\" learns: \"%s\" does not; or give a signed consent (--consent and "
           "--consent-key)",
           name, why_forbidden(rights).c_str(), recipe.c_str(), untrained);
  }
  return consent;
}

std::string provenance_of(const Consent& consent) {
  const SignatureFacts& signature = consent.signature;
  const nlohmann::ordered_json json = {{"performer", consent.performer},
                                       {"agreement", consent.agreement},
                                       {"permits", consent.permits},
                                       {"expires", consent.expires},
                                       {"sources", consent.sources},
                                       {"sha256", consent.sha256},
                                       {"signed_by", signature.signer.subject},
                                       {"signed_at", signature.signed_at},
                                       {"key_sha256", signature.signer.key_sha256}};
  return json.dump();
}

}  // namespace fb::bake
