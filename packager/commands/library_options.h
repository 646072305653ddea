// Options of baking, declared as the library describes them (fb_option_at).
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "options/command.h"

namespace fb::tool {

// The option of this name, of a command that keeps its value itself. Value: std::string, std::uint64_t, or bool of a
// flag; the default is what it holds.
template <typename Value>
Option add_library_option(Command command, const std::string& name, Value& to);

// All options of some parts, for a command that hands them on by name: new ones need nothing here.
class LibraryOptions {
 public:
  // Declares those of `part`, FB_OPTION_..., but for those that commands have a form of their own of.
  void add_to(Command command, std::int32_t part);
  // Those that the command line gave, "NAME=VALUE" each.
  std::vector<std::string> given() const;

 private:
  struct Given {
    std::string name, value;
    bool flag = false;
    std::optional<Option> option;
  };
  std::deque<Given> options_;  // does not move, as the command line refers to values
};

}  // namespace fb::tool
