#include "base/csv_file.h"

#include <algorithm>

#include "base/file.h"
#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "base/utf16.h"

namespace fb {
namespace {

constexpr std::size_t most_csv_bytes = std::size_t{1} << 30;

std::string text_of(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, most_csv_bytes);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (is_utf16(text)) return with_path(path, [&] { return utf8_from_utf16(text); });
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return text;
}

// That of a line of names: which it has most of.
char separator_of(const std::string& line) {
  const char all[] = {',', ';', '\t'};
  return *std::ranges::max_element(all, {}, [&](char one) { return std::ranges::count(line, one); });
}

std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    const std::string cell = line.substr(begin, end - begin);
    const std::size_t first = cell.find_first_not_of(" \t\"\r"), last = cell.find_last_not_of(" \t\"\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    begin = end + 1;
  }
  return cells;
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path) : shown_path_(shown(path)), text_(text_of(path)) {
  text_.exceptions(std::ios::badbit);  // memory that runs out is no end of the file
  std::string line;
  std::getline(text_, line);
  if (line.starts_with("sep=") && line.size() > 4) {
    separator_ = line[4];
    std::getline(text_, line);
    ++line_;
  } else {
    separator_ = separator_of(line);
  }
  names_ = cells_of(line, separator_);
}

bool CsvFile::next() {
  for (std::string line; std::getline(text_, line);) {
    ++line_;
    cells_ = cells_of(line, separator_);
    if (cells_.size() == 1 && cells_[0].empty()) continue;
    if (cells_.size() != names_.size())
      fail(Status::bad_data, "%s: %zu cells where the first line names %zu", where().c_str(), cells_.size(),
           names_.size());
    return true;
  }
  return false;
}

float CsvFile::number(std::size_t column) const {
  std::string cell = cells_[column];
  if (separator_ != ',') std::ranges::replace(cell, ',', '.');
  const auto value = parse_number<float>(cell);
  if (!value)
    fail(Status::bad_data, "%s, column \"%s\": \"%s\" is no number", where().c_str(), names_[column].c_str(),
         cell.c_str());
  return *value;
}

std::string CsvFile::where() const {
  return format("%s, line %zu", shown_path_.c_str(), line_);
}

}  // namespace fb
