#pragma once

#include <string>
#include <vector>

namespace fb::tool {

// A word as a POSIX shell reads it, in quotes where need be; several with spaces between them.
std::string shell_word(const std::string& word);
std::string shell_words(const std::vector<std::string>& words);

// The words of a line as in a shell: quotes, backslash, $VARIABLE, ~ and patterns of file names; no commands. Fails
// with bad_data, saying what is wrong with the line.
std::vector<std::string> words_of_line(const std::string& line);

}  // namespace fb::tool
