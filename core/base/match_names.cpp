#include "base/match_names.h"

#include <algorithm>
#include <unordered_map>

#include "base/shown_path.h"

namespace fb {
namespace {

std::string plain_name(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z') plain += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) plain += c;
  }
  for (const std::string side : {"left", "right"})
    if (plain.size() > side.size() && plain.ends_with(side)) plain.resize(plain.size() - side.size() + 1);
  return plain;
}

// The optimal string alignment distance of two words: edits of single letters and swaps of neighbours.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> rows(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        rows[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = rows[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      rows[i][j] = std::min({rows[i - 1][j] + 1, rows[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        rows[i][j] = std::min(rows[i][j], rows[i - 2][j - 2] + 1);
    }
  return rows.back().back();
}

}  // namespace

std::vector<std::optional<std::size_t>> match_names(const std::vector<std::string>& names,
                                                    const std::vector<std::vector<std::string>>& things) {
  std::size_t most = 0;
  for (const auto& own : things) most = std::max(most, own.size());
  std::unordered_map<std::string, std::size_t> exact, plain;
  for (std::size_t rank = 0; rank < most; ++rank)
    for (std::size_t t = 0; t < things.size(); ++t)
      if (rank < things[t].size() && !things[t][rank].empty()) {
        exact.emplace(things[t][rank], t);
        plain.emplace(plain_name(things[t][rank]), t);
      }
  plain.erase("");
  std::vector<std::optional<std::size_t>> found;
  for (const std::string& name : names) {
    const auto same = exact.find(name), alike = plain.find(plain_name(name));
    if (same != exact.end())
      found.emplace_back(same->second);
    else if (alike != plain.end())
      found.emplace_back(alike->second);
    else
      found.emplace_back();
  }
  return found;
}

std::optional<std::string> nearest_name(const std::string& word, const std::vector<std::string>& names) {
  constexpr std::size_t longest_word = 64;  // of a name; what is longer is no slip
  if (word.size() > longest_word) return {};
  std::optional<std::string> nearest;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : names)
    if (const std::size_t distance = edit_distance(word, name); distance < least) {
      least = distance;
      nearest = name;
    }
  return nearest;
}

std::string list_of_names(const std::vector<std::string>& names, std::size_t most) {
  std::string list;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i)
    list += (i > 0 ? ", \"" : "\"") + shown(names[i]) + "\"";
  if (names.size() > most) list += format(" and %zu more", names.size() - most);
  return list;
}

std::string names_there_are(const std::string& word, const std::vector<std::string>& names) {
  if (names.empty()) return "; there are none";
  const auto nearest = nearest_name(word, names);
  return (nearest ? "; the closest is \"" + shown(*nearest) + "\"" : std::string()) + "; there are " +
         list_of_names(names);
}

}  // namespace fb
