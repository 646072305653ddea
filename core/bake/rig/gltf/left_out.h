#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace fb::bake {

// What a reader leaves out of a file, gathered into one note a kind.
class LeftOut {
 public:
  // `kind`: "skins are left out"; `name`: of what has it. Names that occur twice are named once.
  void add(const std::string& kind, const std::string& name);
  // A part that cannot be read: `reason` names it.
  void add_broken(const std::string& reason);
  // One a kind, in the order in which they were added: "skins are left out: \"head\", \"teeth\"". Of more than three
  // names, the others are counted.
  std::vector<std::string> notes() const;

 private:
  struct Kind {
    std::size_t order;
    std::set<std::string> names;
    std::vector<std::string> first;  // names that are shown
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace fb::bake
