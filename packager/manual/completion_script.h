#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace fb::tool {

// "bash", "fish", "zsh".
std::vector<std::string> completion_shells();

// The script by which one of these shells completes the tool's commands, options and what options take.
std::string completion_script(const CLI::App& tool, const std::string& shell);

}  // namespace fb::tool
