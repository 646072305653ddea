#pragma once

#include <string>

namespace fb::tool {

// Has the desktop open an address in a browser (xdg-open), and does not wait for it. False where there is no such
// program.
bool open_browser(const std::string& address);

}  // namespace fb::tool
