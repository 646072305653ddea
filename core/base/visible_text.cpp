#include "base/visible_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "base/utf8.h"

namespace fb {
namespace {

constexpr std::size_t most_growth = 6;  // of a byte that becomes "\u001b"

std::uint32_t byte_at(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

// The first character; none if the text does not begin with one.
std::string_view first_character(std::string_view text) {
  const std::uint32_t first = byte_at(text, 0);
  const std::size_t size = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  const std::string_view character = text.substr(0, size);
  return character.size() == size && !find_utf8_fault(character) ? character : std::string_view();
}

std::uint32_t code_of(std::string_view character) {
  std::uint32_t code = byte_at(character, 0) & (0xffu >> (character.size() == 1 ? 0 : character.size() + 1));
  for (std::size_t i = 1; i < character.size(); ++i) code = code << 6 | (byte_at(character, i) & 0x3fu);
  return code;
}

bool is_hidden(std::uint32_t code, Layout layout) {
  if (code == '\n' || code == '\t') return layout == Layout::hidden;
  const auto among = [&](std::uint32_t first, std::uint32_t last) { return first <= code && code <= last; };
  return code < ' ' || among(0x7f, 0x9f) || among(0x200e, 0x200f) || among(0x2028, 0x202e) || among(0x2066, 0x2069);
}

}  // namespace

std::size_t write_visible_text(std::string_view text, Layout layout, std::span<char> to) noexcept {
  std::size_t written = 0;
  while (!text.empty()) {
    std::string_view character = first_character(text), shown = character;
    std::array<char, 16> escape{};
    const std::uint32_t code = character.empty() ? byte_at(text, 0) : code_of(character);
    if (character.empty() || is_hidden(code, layout)) {
      const char* const form = character.empty() ? "\\x%02x" : "\\u%04x";
      const int size = std::snprintf(escape.data(), escape.size(), form, static_cast<unsigned>(code));
      shown = {escape.data(), static_cast<std::size_t>(size)};
    }
    if (shown.size() > to.size() - written) break;
    std::copy(shown.begin(), shown.end(), to.begin() + static_cast<std::ptrdiff_t>(written));
    written += shown.size();
    text.remove_prefix(std::max<std::size_t>(character.size(), 1));
  }
  return written;
}

std::string visible_text(std::string_view text, Layout layout) {
  std::string visible(most_growth * text.size(), '\0');
  visible.resize(write_visible_text(text, layout, visible));
  return visible;
}

}  // namespace fb
