#include "farm/shell_words.h"

#include <wordexp.h>

#include "base/status.h"

namespace fb::tool {
namespace {

const char* fault_text(int fault) {
  switch (fault) {
    case WRDE_BADCHAR:
      return "one of |&;<>(){} has to be in quotes";
    case WRDE_BADVAL:
      return "a $VARIABLE is not set; in single quotes, $ is a character like any other";
    case WRDE_CMDSUB:
      return "$(...) and `...` are not run; in single quotes, they are characters like any other";
    case WRDE_SYNTAX:
      return "a quote is not closed";
    default:
      return "out of memory";
  }
}

}  // namespace

std::string shell_word(const std::string& word) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./=:,+@%").find(c) != std::string_view::npos;
  };
  bool needs_quotes = word.empty();
  std::string quoted = "'";
  for (const char c : word) {
    needs_quotes = needs_quotes || !plain(c);
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  }
  return needs_quotes ? quoted + "'" : word;
}

std::string shell_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += ' ';
    text += shell_word(word);
  }
  return text;
}

std::vector<std::string> words_of_line(const std::string& line) {
  wordexp_t found = {};
  if (const int fault = ::wordexp(line.c_str(), &found, WRDE_NOCMD | WRDE_UNDEF)) {
    if (fault == WRDE_NOSPACE) ::wordfree(&found);
    fail(Status::bad_data, "%s", fault_text(fault));
  }
  std::vector<std::string> words(found.we_wordv, found.we_wordv + found.we_wordc);
  ::wordfree(&found);
  return words;
}

}  // namespace fb::tool
