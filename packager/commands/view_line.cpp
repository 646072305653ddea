#include "commands/view_line.h"

#include "farm/shell_words.h"

namespace fb::tool {

std::string view_line(const std::string& archive, const std::vector<std::string>& sources) {
  return "facebaker " + shell_words({"view", archive, "--beside", sources.at(0)});
}

}  // namespace fb::tool
