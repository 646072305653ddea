#pragma once

#include <optional>
#include <string>
#include <vector>

namespace fb {

// Which of several things each name means; nothing where it means none. `things`: the names of each, those that count
// first in front, empty ones left out. A name is matched exactly if it can be, and else without regard to case and to
// what is neither letter nor digit, "left" and "right" at the end being as good as "l" and "r".
std::vector<std::optional<std::size_t>> match_names(const std::vector<std::string>& names,
                                                    const std::vector<std::vector<std::string>>& things);

// The name that a mistyped word most likely means: the one with the fewest letters added, left out, replaced or swapped
// with their neighbour, at most one in three of the word's; the first of several. Nothing where none is that near.
std::optional<std::string> nearest_name(const std::string& word, const std::vector<std::string>& names);

// The rest of a sentence that begins with a word which is none of `names`: `; the closest is "jaw"; there are "jaw",
// "brow" and 3 more`. Ten are listed.
std::string names_there_are(const std::string& word, const std::vector<std::string>& names);
// `"jaw", "brow" and 3 more`.
std::string list_of_names(const std::vector<std::string>& names, std::size_t most = 10);

}  // namespace fb
