// What may be done with a character, as its archive says, and what of it binds where two fields disagree.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/calendar_day.h"

namespace fb::bake {

// The stricter is the greater.
enum class Permission { unstated, allowed, constrained, not_allowed };

struct Rights {
  // As they are given; "", which says nothing, where they are not. A value of another type is its JSON.
  std::string licence, consent, uses, expires, learning;
  std::string performer, agreement, territory, suspendable, consent_state, recognisable, digital_source_type;
  std::string ai_training, ai_generative_training, data_mining, constraint_info;
  // Clauses about what is there and is not as TEXTS.md has it; it is taken for the strictest that it could mean.
  std::vector<std::string> unread;
  bool unreadable = false;  // all of them: then nothing is allowed

  bool empty() const;  // nothing is said

  // Whether others may learn from the character, train models on it, train models on it that generate, and mine it for
  // data. Of the first three each is as strict as `learning`, and `learning` as strict as the other two. `constrained`
  // without constraint_info is not allowed, as CAWG's assertion has it.
  Permission learning_permission() const;
  Permission training_permission() const;
  Permission generative_training_permission() const;
  Permission mining_permission() const;

  bool can_be_suspended() const;  // the consent; other words than "no" say so, too
  // The last day on which they hold, by `expires`; none where it is no date.
  std::optional<CalendarDay> last_day() const;
  bool expired(CalendarDay on) const;
};

// The rights in what is said about a character: a JSON object with `rights`, from anyone. None where there are none;
// never fails on what it reads.
Rights rights_in(std::string_view about);

}  // namespace fb::bake
