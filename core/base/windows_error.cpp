#include "base/windows_error.h"

#include <windows.h>

namespace fb {

std::string windows_reason(unsigned long error) {
  wchar_t wide[256];
  const DWORD length = FormatMessageW(FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS, nullptr, error, 0,
                                      wide, sizeof wide / sizeof *wide, nullptr);
  char text[3 * sizeof wide / sizeof *wide];
  const int bytes =
      WideCharToMultiByte(CP_UTF8, 0, wide, static_cast<int>(length), text, sizeof text, nullptr, nullptr);
  std::string reason(text, bytes > 0 ? static_cast<std::size_t>(bytes) : 0);
  reason.resize(reason.find_last_not_of(" .\r\n") + 1);
  return reason.empty() ? "error " + std::to_string(error) : reason;
}

}  // namespace fb
