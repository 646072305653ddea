#include "commands/tool_version.h"

#include <facebaker/facebaker.h>

#include <string_view>

namespace fb::tool {

std::string tool_version() {
  std::string_view library = fb_build_info();
  library.remove_prefix(library.find('\n') + 1);  // its version is the tool's
  return "facebaker " FB_VERSION "\n" + std::string(library) + "linked into the tool: " FB_LINKED;
}

}  // namespace fb::tool
