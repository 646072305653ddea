// What a terminal is like, for text that a person reads.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fb::tool {

// Columns of the terminal at a descriptor, or as the environment's COLUMNS says; 0: neither tells.
std::size_t terminal_width(int descriptor);

// Whether text to a descriptor is coloured: on a terminal that is not "dumb", and where FORCE_COLOR is set to anything
// but 0, unless NO_COLOR is set (no-color.org). Files are never coloured.
bool takes_colour(int descriptor);

// Prints a line on standard error, names from anyone in it as visible_text.h makes them. `start`: text of ours before
// it.
void print_line(std::string_view line, std::string_view start = {});

enum class Colour { heading, name, warning, error };

// The text, between the codes of a colour if `coloured`.
std::string in_colour(Colour colour, std::string_view text, bool coloured);

// The text's paragraphs broken at spaces so that no line is longer than `width` columns, where words allow; every line
// but the first begins with `indent` spaces, and the first has that much room too. 0: not broken. Bytes of UTF-8
// sequences after the first count as no column.
std::string wrapped(std::string_view text, std::size_t indent, std::size_t width);

// The text cut to at most so many columns.
std::string cut_to_width(std::string_view text, std::size_t columns);

}  // namespace fb::tool
