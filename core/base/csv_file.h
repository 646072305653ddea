// Tables in text files, such as recordings of facial capture.
#pragma once

#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace fb {

// Reads a file of separated values whose first line names its columns, line by line, as spreadsheets of any language
// save them: in UTF-8 or UTF-16, and separated by commas, semicolons or tabs, whichever the first line has, or says
// ("sep=;"). With semicolons and tabs, numbers may have a decimal comma. Quotes and blanks around cells, a byte order
// mark, line ends of Windows and empty lines are left out. Messages name file, line and column.
class CsvFile {
 public:
  // Fails as read_file does, with limit beyond 1 GiB, and with bad_data on UTF-16 that is not whole.
  explicit CsvFile(const std::filesystem::path& path);

  const std::vector<std::string>& names() const { return names_; }
  // Reads the next line that is not empty; false at the end. Fails with bad_data where it has more or fewer cells than
  // there are names.
  bool next();
  const std::string& cell(std::size_t column) const { return cells_[column]; }
  // Fails with bad_data if the cell is no number; an infinite or undefined one is a number.
  float number(std::size_t column) const;
  std::size_t line() const { return line_; }  // of the cells, counted from 1
  // "FILE, line N", for messages.
  std::string where() const;

 private:
  std::string shown_path_;
  std::istringstream text_;
  std::vector<std::string> names_, cells_;
  std::size_t line_ = 1;
  char separator_ = ',';
};

}  // namespace fb
