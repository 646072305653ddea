#include "base/file_extension.h"

namespace fb {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::string file_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

}  // namespace fb
