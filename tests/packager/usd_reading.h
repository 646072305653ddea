// Lists of numbers in USD's text.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace fb::test {

// The numbers of a list, of tuples too, that begins at `first` and ends with its line.
inline std::vector<float> numbers_of(const std::string& line, std::size_t first) {
  std::string text = line.substr(first);
  for (char& c : text)
    if (c == '(' || c == ')' || c == '[' || c == ']' || c == ',') c = ' ';
  std::istringstream words(text);
  std::vector<float> numbers;
  for (std::string word; words >> word;) numbers.push_back(std::stof(word));
  return numbers;
}

// Those of every attribute of this name and type, such as "point3f[] points", in the order of the text.
inline std::vector<std::vector<float>> lists_of(const std::string& text, const std::string& attribute) {
  std::vector<std::vector<float>> lists;
  std::istringstream lines(text);
  const std::string begin = attribute + " = [";
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t at = line.find(begin); at != std::string::npos)
      lists.push_back(numbers_of(line, at + begin.size()));
  return lists;
}

}  // namespace fb::test
