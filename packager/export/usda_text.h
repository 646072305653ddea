// Pieces of USD's text form.
#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>

namespace fb::tool {

// A quoted string, with quotes, backslashes and control characters escaped.
std::string usda_string(const std::string& text);

// A prim's name made of any name: letters, digits and underscores, not in `taken`, which it joins.
std::string usda_identifier(const std::string& name, std::set<std::string>& taken);

// "[1, 2, 3]"; and "[(0, 0), (1, 0)]" of tuples of `width`.
std::string usda_integers(std::span<const std::uint32_t> values);
std::string usda_tuples(std::span<const float> values, std::size_t width);
std::string usda_tuple(std::span<const float> values);

}  // namespace fb::tool
