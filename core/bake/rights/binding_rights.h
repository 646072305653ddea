// What rights bind to on a day, in words and as a document.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bake/rights/rights.h"

namespace fb::bake {

// Clauses about what is not simply permitted, what ended first: "expired: the rights ended on 2030-01-01". Words of the
// rights are as shown() makes them. Empty where nothing binds.
std::vector<std::string> binding_rights(const Rights& rights, CalendarDay on);

// {"on", "expired", "last_day", "learning", "ai_training", "ai_generative_training", "data_mining", "suspendable",
// "binding"[], "unread"[]}: permissions as strict as they are (Rights), in the terms of their fields, constrained ones
// "constrained". Without a date last_day is missing, and what nothing is said about.
nlohmann::ordered_json rights_document(const Rights& rights, CalendarDay on);

}  // namespace fb::bake
