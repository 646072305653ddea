#pragma once

#include <string>
#include <vector>

namespace fb::tool {

// The line of a shell that shows an archive beside the first of its sources in the viewer.
std::string view_line(const std::string& archive, const std::vector<std::string>& sources);

}  // namespace fb::tool
