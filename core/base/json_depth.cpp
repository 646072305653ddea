#include "base/json_depth.h"

#include "base/status.h"

namespace fb {

void check_json_depth(std::string_view text) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\')
      ++i;  // whatever is escaped, it does not end the string
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '{' || c == '['))
      ++depth;
    else if (!quoted && (c == '}' || c == ']') && depth > 0)
      --depth;
    if (depth > most_json_levels)
      fail(Status::bad_data, "JSON: byte %zu lies more than %zu objects and arrays deep", i, most_json_levels);
  }
}

}  // namespace fb
