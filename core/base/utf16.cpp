#include "base/utf16.h"

#include <cstddef>

#include "base/status.h"

namespace fb {
namespace {

bool begins_little(std::string_view bytes) {
  return bytes.size() >= 2 && (bytes.starts_with("\xff\xfe") || (bytes[0] != '\0' && bytes[1] == '\0'));
}

bool begins_big(std::string_view bytes) {
  return bytes.size() >= 2 && (bytes.starts_with("\xfe\xff") || (bytes[0] == '\0' && bytes[1] != '\0'));
}

void append_utf8(std::string& text, unsigned point) {
  if (point < 0x80) {
    text += static_cast<char>(point);
    return;
  }
  const int more = point < 0x800 ? 1 : point < 0x10000 ? 2 : 3;
  constexpr unsigned first_bits[] = {0, 0xc0, 0xe0, 0xf0};
  text += static_cast<char>(first_bits[more] | point >> 6 * more);
  for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80 | (point >> 6 * i & 0x3f));
}

}  // namespace

bool is_utf16(std::string_view bytes) {
  return begins_little(bytes) || begins_big(bytes);
}

std::string utf8_from_utf16(std::string_view bytes) {
  const bool big = begins_big(bytes);
  const auto unit = [&](std::size_t at) -> unsigned {
    if (at + 1 >= bytes.size()) fail(Status::bad_data, "ends within a character of UTF-16, at byte %zu", at);
    const auto first = static_cast<unsigned char>(bytes[at]), second = static_cast<unsigned char>(bytes[at + 1]);
    return big ? unsigned{first} << 8 | second : unsigned{second} << 8 | first;
  };
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    unsigned point = unit(at);
    if (at == 0 && point == 0xfeff) continue;
    if (point >= 0xd800 && point < 0xe000) {
      const unsigned low = point < 0xdc00 ? unit(at + 2) : 0;
      if (low < 0xdc00 || low >= 0xe000) fail(Status::bad_data, "half a character of UTF-16 at byte %zu", at);
      point = 0x10000 + ((point - 0xd800) << 10) + (low - 0xdc00);
      at += 2;
    }
    append_utf8(text, point);
  }
  return text;
}

}  // namespace fb
