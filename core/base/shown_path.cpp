#include "base/shown_path.h"

#include "base/visible_text.h"

namespace fb {
namespace {

constexpr std::size_t longest = 240;

bool continues_a_character(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

}  // namespace

std::string shown(std::string_view name) {
  const std::string text = visible_text(name, Layout::hidden);
  if (text.size() <= longest) return text;
  // More of the end than of the beginning: a path ends with what tells files apart.
  std::size_t first = longest / 4, last = text.size() - 3 * longest / 4 + 3;
  while (first > 0 && continues_a_character(text[first])) --first;
  while (last < text.size() && continues_a_character(text[last])) ++last;
  return text.substr(0, first) + "..." + text.substr(last);
}

void fail_on(const std::filesystem::path& path, Status status, const std::string& reason) {
  const std::string place = " (" + shown(path) + ")";
  throw Error(status, reason.ends_with(place) ? reason : reason + place);
}

}  // namespace fb
