#pragma once

#include <string>
#include <string_view>

namespace fb {

// Whether a file is UTF-16: it begins with a byte order mark of that, or with a letter beside a zero byte.
bool is_utf16(std::string_view bytes);

// UTF-16 of either byte order, with or without its mark, as UTF-8. Fails with bad_data, naming the byte, on half a
// character.
std::string utf8_from_utf16(std::string_view bytes);

}  // namespace fb
