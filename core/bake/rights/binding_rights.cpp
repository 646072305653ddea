#include "bake/rights/binding_rights.h"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "bake/rights/rights_terms.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// "ai_training: notAllowed", of those of the fields that constrain or forbid, with what CAWG's terms say besides.
std::string reasons(const Rights& rights, std::initializer_list<std::string Rights::*> fields) {
  std::string text;
  for (const RightsField& field : rights_fields()) {
    const std::string& value = rights.*field.value;
    if (std::ranges::find(fields, field.value) == fields.end() || value.empty() || value == "allowed") continue;
    text += (text.empty() ? " (" : "; ") + std::string(field.key) + ": " + shown(value);
    if (value != "constrained") continue;
    text += rights.constraint_info.empty() ? ", without a word on how" : ", " + shown(rights.constraint_info);
  }
  return text.empty() ? "" : text + ")";
}

void add_expiry(std::vector<std::string>& clauses, const Rights& rights, CalendarDay on) {
  if (rights.expires.empty()) return;
  if (const auto last = rights.last_day())
    clauses.push_back((on > *last ? "expired: the rights ended on " : "the rights end on ") + calendar_day_text(*last));
  else
    clauses.push_back("the rights expire: \"" + shown(rights.expires) +
                      "\", which is no date that can be checked (2031-12-31 is one)");
}

// "learning from it is forbidden (ai_training: notAllowed)".
void add_permission(std::vector<std::string>& clauses, const std::string& what, Permission permission,
                    const std::string& why) {
  if (permission == Permission::constrained) clauses.push_back(what + " is constrained" + why);
  if (permission == Permission::not_allowed) clauses.push_back(what + " is forbidden" + why);
}

void add_words(std::vector<std::string>& clauses, const std::string& what, const std::string& words) {
  if (!words.empty()) clauses.push_back(what + shown(words));
}

}  // namespace

std::vector<std::string> binding_rights(const Rights& rights, CalendarDay on) {
  std::vector<std::string> clauses;
  add_expiry(clauses, rights, on);
  for (const std::string& clause : rights.unread) clauses.push_back(clause + "; it is taken for the strictest");
  add_permission(clauses, "learning from it", rights.learning_permission(),
                 reasons(rights, {&Rights::learning, &Rights::ai_training, &Rights::ai_generative_training}));
  add_permission(clauses, "mining it for data", rights.mining_permission(), reasons(rights, {&Rights::data_mining}));
  add_words(clauses, "permitted uses: ", rights.uses);
  add_words(clauses, "territory: ", rights.territory);
  if (rights.can_be_suspended())
    clauses.push_back("the consent can be suspended; " +
                      (rights.consent_state.empty() ? "where its state is asked is not said"
                                                    : "its state is asked at: " + shown(rights.consent_state)));
  return clauses;
}

nlohmann::ordered_json rights_document(const Rights& rights, CalendarDay on) {
  nlohmann::ordered_json document = {{"on", calendar_day_text(on)}, {"expired", rights.expired(on)}};
  if (const auto last = rights.last_day()) document["last_day"] = calendar_day_text(*last);
  const auto add = [&](const char* key, Permission permission, const char* not_allowed) {
    if (permission == Permission::unstated) return;
    document[key] = permission == Permission::allowed       ? "allowed"
                    : permission == Permission::constrained ? "constrained"
                                                            : not_allowed;
  };
  add("learning", rights.learning_permission(), "forbidden");
  add("ai_training", rights.training_permission(), "notAllowed");
  add("ai_generative_training", rights.generative_training_permission(), "notAllowed");
  add("data_mining", rights.mining_permission(), "notAllowed");
  if (!rights.suspendable.empty()) document["suspendable"] = rights.can_be_suspended();
  document["binding"] = binding_rights(rights, on);
  document["unread"] = rights.unread;
  return document;
}

}  // namespace fb::bake
