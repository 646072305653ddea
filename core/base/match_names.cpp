#include "base/match_names.h"

#include <algorithm>
#include <unordered_map>

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

}  // namespace fb
