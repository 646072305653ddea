#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace fb::tool {

// The figures of a report and what they are, in one sentence each: shown where their names are headings.
using GlossaryEntry = std::pair<std::string_view, std::string_view>;
std::span<const GlossaryEntry> glossary();

// Empty for a heading that is no figure.
std::string_view explanation_of(std::string_view heading);

}  // namespace fb::tool
