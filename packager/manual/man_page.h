#pragma once

#include <string>

namespace CLI {
class App;
}

namespace fb::tool {

// The man page of the tool, facebaker(1), in roff for man(1).
std::string man_page(const CLI::App& tool);

// The man page of one of its commands, such as facebaker-bake(1).
std::string man_page(const CLI::App& tool, const CLI::App& command);

}  // namespace fb::tool
