#include "report/table.h"

#include <algorithm>

namespace fb::tool {
namespace {

// Characters of UTF-8 text, each taken to be one column wide.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char byte) { return (byte & 0xc0) != 0x80; }));
}

}  // namespace

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 3);
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      std::string cell = c < rows_[r].size() ? rows_[r][c] : "";
      for (char& byte : cell)
        if (static_cast<unsigned char>(byte) < 32 || byte == 127) byte = '?';
      const std::string space(widths[c] - width(cell), ' ');
      text += "| " + (c == 0 ? cell + space : space + cell) + " ";
    }
    text += "|\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c)
      text += c == 0 ? "| " + std::string(widths[c], '-') + " " : "| " + std::string(widths[c] - 1, '-') + ": ";
    text += "|\n";
  }
  return text;
}

}  // namespace fb::tool
