// Standard output, which is for results alone.
#pragma once

#include <string>

namespace fb::tool {

// Keeps standard output for results and has everything else that is printed there, by rigs and libraries, go to
// standard error. Standard streams that are closed become /dev/null. Once, at the start.
void reserve_standard_output();

// Where results go, to ask what it is like; -1: nowhere. After reserve_standard_output.
int results_descriptor();

// Prints a result as visible_text.h makes it. Fails with io where standard output takes no more, as finish_results.
void print_result(const std::string& text);
void finish_results();

}  // namespace fb::tool
