#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace fb::tool {

// The figures of a report and what they are, in one sentence each: shown where their names are.
using GlossaryEntry = std::pair<std::string_view, std::string_view>;
std::span<const GlossaryEntry> glossary();

// The index of a figure; nothing for what is no name of one.
std::optional<std::size_t> glossary_entry(std::string_view name);

}  // namespace fb::tool
