#include "bake/sampling/mirror_partners.h"

#include <algorithm>

namespace fb::bake {
namespace {

bool is_lower(char c) {
  return c >= 'a' && c <= 'z';
}
bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}
char lower(char c) {
  return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
}

// Where a name says a side: the text there and that of the other side.
struct Side {
  std::size_t at;
  std::string here, there;
};

// "left" -> "right", "Left" -> "Right", "LEFT" -> "RIGHT".
std::string in_case_of(const std::string& word, const std::string& example) {
  std::string text = word;
  const bool all = is_upper(example.back());
  for (std::size_t i = 0; i < text.size(); ++i)
    if (is_upper(example[0]) && (i == 0 || all)) text[i] = static_cast<char>(text[i] - 'a' + 'A');
  return text;
}

std::vector<Side> sides_of(const std::string& name) {
  std::vector<Side> sides;
  std::string small = name;
  std::transform(small.begin(), small.end(), small.begin(), lower);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i], before = i > 0 ? name[i - 1] : '_';
    // "upright" says no side, "upRight" and "up_right" do.
    const bool begins = is_upper(c) ? !is_upper(before) : !is_upper(before) && !is_lower(before);
    if (!begins) continue;
    bool word_here = false;
    for (const auto& [word, other] : {std::pair<std::string, std::string>{"left", "right"}, {"right", "left"}})
      if (small.compare(i, word.size(), word) == 0) {
        const std::string here = name.substr(i, word.size());
        sides.push_back({i, here, in_case_of(other, here)});
        word_here = true;
      }
    const char after = i + 1 < name.size() ? name[i + 1] : '_';
    const bool ends = !is_lower(after) && (is_upper(c) || !is_upper(after));
    if (!word_here && ends && (lower(c) == 'l' || lower(c) == 'r'))
      sides.push_back({i, {c}, {c == 'L' ? 'R' : c == 'R' ? 'L' : c == 'l' ? 'r' : 'l'}});
  }
  return sides;
}

}  // namespace

std::vector<std::string> other_side_names(const std::string& name) {
  const std::vector<Side> sides = sides_of(name);
  std::vector<std::string> names;
  std::string all = name;
  for (std::size_t s = sides.size(); s-- > 0;) {
    std::string one = name;
    one.replace(sides[s].at, sides[s].here.size(), sides[s].there);
    all.replace(sides[s].at, sides[s].here.size(), sides[s].there);
    names.push_back(one);
  }
  if (sides.size() > 1) names.push_back(all);
  return names;
}

}  // namespace fb::bake
