#include "commands/terminal.h"

#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "base/visible_text.h"

namespace fb::tool {
namespace {

// A variable's value; "" if there is none.
std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

bool begins_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0) != 0x80;
}

std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

const char* code_of(Colour colour) {
  switch (colour) {
    case Colour::heading:
      return "\033[1m";
    case Colour::name:
      return "\033[36m";
    case Colour::warning:
      return "\033[33m";
    case Colour::error:
      return "\033[1;31m";
  }
  return "";
}

}  // namespace

std::size_t terminal_width(int descriptor) {
  winsize size = {};
  if (::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const std::string_view columns = environment("COLUMNS");
  const bool number = !columns.empty() && columns.size() < 5 && columns.find_first_not_of("0123456789") == columns.npos;
  return number ? std::strtoul(columns.data(), nullptr, 10) : 0;
}

bool takes_colour(int descriptor) {
  struct stat file = {};
  if (!environment("NO_COLOR").empty() || ::fstat(descriptor, &file) != 0 || S_ISREG(file.st_mode)) return false;
  if (const std::string_view forced = environment("FORCE_COLOR"); !forced.empty()) return forced != "0";
  return ::isatty(descriptor) && environment("TERM") != "dumb";
}

void print_line(std::string_view line, std::string_view start) {
  const std::string text = std::string(start) + visible_text(line, Layout::kept) + "\n";
  std::fputs(text.c_str(), stderr);
}

std::string in_colour(Colour colour, std::string_view text, bool coloured) {
  return coloured ? code_of(colour) + std::string(text) + "\033[0m" : std::string(text);
}

std::string wrapped(std::string_view text, std::size_t indent, std::size_t width) {
  if (width <= indent) return std::string(text);
  const std::string margin(indent, ' ');
  std::string lines;
  std::size_t column = indent;
  while (!text.empty()) {
    if (text.front() == '\n') {
      lines += "\n" + margin;
      column = indent;
      text.remove_prefix(1);
      continue;
    }
    const std::size_t spaces = std::min(text.find_first_not_of(' '), text.size());
    const std::size_t end = std::min(text.find_first_of(" \n", spaces), text.size());
    const std::string_view word = text.substr(spaces, end - spaces);
    const std::size_t columns = columns_of(word);
    if (column > indent && column + spaces + columns > width) {
      lines += "\n" + margin;
      column = indent;
    } else {
      lines.append(spaces, ' ');
      column += spaces;
    }
    lines += word;
    column += columns;
    text.remove_prefix(end);
  }
  return lines;
}

std::string cut_to_width(std::string_view text, std::size_t columns) {
  std::size_t end = 0;
  for (; end < text.size(); ++end)
    if (begins_character(text[end]) && columns-- == 0) break;
  return std::string(text.substr(0, end));
}

}  // namespace fb::tool
