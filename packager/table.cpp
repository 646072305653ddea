#include "table.h"

#include <algorithm>

namespace fb {

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 3);
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      std::string cell = c < rows_[r].size() ? rows_[r][c] : "";
      for (char& byte : cell)
        if (static_cast<unsigned char>(byte) < 32 || byte == 127) byte = '?';
      const std::string space(widths[c] - cell.size(), ' ');
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

}  // namespace fb
