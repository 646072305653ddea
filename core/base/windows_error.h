#pragma once

#include <string>

namespace fb {

// What Windows says of an error of GetLastError(), in UTF-8 without a full stop; its number if it has no text.
std::string windows_reason(unsigned long error);

}  // namespace fb
