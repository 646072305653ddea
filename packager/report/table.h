#pragma once

#include <string>
#include <vector>

namespace fb::tool {

// A text table that is also valid Markdown: the first column flush left, the others flush right.
class Table {
 public:
  explicit Table(std::vector<std::string> heads) : rows_{std::move(heads)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  // One line a row. Control characters, which names in a foreign file may have, become question marks.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace fb::tool
