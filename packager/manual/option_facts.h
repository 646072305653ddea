// What a command's declaration says of its options, as the writers of man pages and completion need it.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fb::tool {

struct OptionFacts {
  std::vector<std::string> names;  // "--out", "-h"; of a positional argument its name alone, "SOURCE"
  bool positional = false, required = false, repeated = false;
  std::string value;                  // the name of what it takes, "FACE.fbk"; "" for a flag
  std::vector<std::string> choices;   // all that it takes, where that is a list of words
  std::string limits;                 // "1 to 1024"; "" if there are none
  std::string standard;               // the default; "" if there is none
  std::vector<std::string> excluded;  // options that it cannot be given with
  std::string description;
};

OptionFacts facts_of(const CLI::Option& option);

// What is to be known beside the description: "required; one of paper, dense; default: dense"; "" if there is nothing.
std::string conditions_of(const OptionFacts& facts);

// Of all options that are shown in the help of a command, positional arguments first.
std::vector<OptionFacts> options_of(const CLI::App& command);

// The commands that are shown in the help of the tool, in its order.
std::vector<const CLI::App*> commands_of(const CLI::App& tool);

}  // namespace fb::tool
