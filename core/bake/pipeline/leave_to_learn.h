// Whose leave a bake needs to learn from a character, and has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bake/recipe/bake_options.h"
#include "bake/rig/source.h"
#include "bake/signing/consent.h"

namespace fb::bake {

// What is said about the character of a source with BakeOptions::about over it. Fails with invalid_argument where the
// source forbids learning and the result does not: of two that disagree the stricter holds.
std::string about_with(const Source& source, const BakeOptions& options);

// Fails with invalid_argument where `about` forbids learning, one of the recipes learns from this source, and no
// consent allows it: the message names a recipe that does not learn. A consent that the options give is checked in any
// case, also where none is needed, and returned: that its signature is by their key, that it holds today and permits
// "learning", and that it is about this character: of the same agreement and performer, and of these source files as
// far as it names some. Notes tell words that learning is constrained by, and that the rights have ended.
std::optional<Consent> leave_to_learn(const std::vector<std::string>& recipes, const Source& source,
                                      const std::string& about, const BakeOptions& options, Progress& progress);

// What the provenance of a face says of the consent it was learned by: a JSON object, with the key that signed it.
std::string provenance_of(const Consent& consent);

}  // namespace fb::bake
