// The fields of "rights" of what is said about a character, and the terms that some of them are of: see "rights" in
// TEXTS.md.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>

#include "bake/rights/rights.h"

namespace fb::bake {

struct RightsField {
  const char* key;
  std::string Rights::*value;
  std::span<const std::string_view> terms;  // that it is one of; empty: any words
};
std::span<const RightsField> rights_fields();

// Whether a value is one of the field's terms. Digital source types may be URIs, too: IPTC's of a term, or those of
// another vocabulary.
bool is_term_of(const RightsField& field, std::string_view value);

// Fails with bad_data, naming the field, where `rights` is no object, where a field that TEXTS.md names is no string
// (null is none), and where one has terms and says something else.
void check_rights(const nlohmann::ordered_json& rights);

}  // namespace fb::bake
