#include "bake/rights/rights.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/rights/rights_terms.h"
#include "base/json_depth.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using nlohmann::ordered_json;

// Null where it is no JSON object.
ordered_json object_of(std::string_view text) {
  try {
    check_json_depth(text);
  } catch (const Error&) {
    return nullptr;
  }
  ordered_json value = ordered_json::parse(text, nullptr, false);
  return value.is_object() ? value : ordered_json();
}

std::string words_of(const ordered_json& value) {
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

// CAWG's terms: what is none of them is not allowed.
Permission permission_of(const Rights& rights, const std::string& value) {
  if (rights.unreadable) return Permission::not_allowed;
  if (value.empty()) return Permission::unstated;
  if (value == "allowed") return Permission::allowed;
  return value == "constrained" && !rights.constraint_info.empty() ? Permission::constrained : Permission::not_allowed;
}

// "allowed", "forbidden" in letters of any case or CAWG's word for it, or words, which constrain it.
Permission own_learning(const Rights& rights) {
  if (rights.learning.empty()) return Permission::unstated;
  if (rights.learning == "allowed") return Permission::allowed;
  std::string lower = rights.learning;
  for (char& letter : lower)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return lower == "forbidden" || lower == "notallowed" ? Permission::not_allowed : Permission::constrained;
}

Rights unreadable_rights(std::string why) {
  Rights rights;
  rights.unreadable = true;
  rights.unread.push_back(std::move(why));
  return rights;
}

}  // namespace

bool Rights::empty() const {
  return unread.empty() &&
         std::ranges::all_of(rights_fields(), [&](const RightsField& field) { return (this->*field.value).empty(); });
}

Permission Rights::training_permission() const {
  return std::max(own_learning(*this), permission_of(*this, ai_training));
}

Permission Rights::generative_training_permission() const {
  return std::max(own_learning(*this), permission_of(*this, ai_generative_training));
}

Permission Rights::learning_permission() const {
  return std::max(training_permission(), generative_training_permission());
}

Permission Rights::mining_permission() const {
  return permission_of(*this, data_mining);
}

bool Rights::can_be_suspended() const {
  return !suspendable.empty() && suspendable != "no";
}

std::optional<CalendarDay> Rights::last_day() const {
  return last_whole_day_in(expires);
}

bool Rights::expired(CalendarDay on) const {
  const std::optional<CalendarDay> last = last_day();
  return last && on > *last;
}

Rights rights_in(std::string_view about) {
  Rights rights;
  if (about.empty()) return rights;
  const ordered_json said = object_of(about);
  if (!said.is_object()) return unreadable_rights("what is said about the character is no JSON object");
  const auto found = said.find("rights");
  if (found == said.end() || found->is_null()) return rights;
  if (!found->is_object()) return unreadable_rights("rights is no object, but " + shown(words_of(*found)));
  for (const RightsField& field : rights_fields()) {
    const auto given = found->find(field.key);
    if (given == found->end() || given->is_null()) continue;
    std::string& value = rights.*field.value = words_of(*given);
    if (!given->is_string())
      rights.unread.push_back(format("rights %s is no string, but %s", field.key, shown(value).c_str()));
    else if (!value.empty() && !is_term_of(field, value))
      rights.unread.push_back(
          format("rights %s is \"%s\", which is none of its terms", field.key, shown(value).c_str()));
  }
  return rights;
}

}  // namespace fb::bake
