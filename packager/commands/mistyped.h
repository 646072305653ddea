// What a mistyped command or option may have meant.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace fb::tool {

// "no command "sampel"; did you mean "sample"?", for a first word that is no command.
std::string unknown_command(const CLI::App& tool, const std::string& word);

// After parsing has failed: "no option --poess; did you mean --poses?" for the first word that is left over and looks
// like an option; "" if there is none.
std::string unknown_option(const CLI::App& command);

}  // namespace fb::tool
