// A check of JSON from anyone before a parser sees it.
#pragma once

#include <cstddef>
#include <string_view>

namespace fb {

inline constexpr std::size_t most_json_levels = 64;

// Fails with bad_data where objects and arrays lie more than most_json_levels deep in each other: those who parse, copy
// or destroy such values recurse. Whether the text is JSON is not checked.
void check_json_depth(std::string_view text);

}  // namespace fb
