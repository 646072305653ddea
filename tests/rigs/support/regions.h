// Which region of the face a control belongs to, told from its name.
#pragma once

#include <string>
#include <vector>

namespace rigs {

struct Region {
  const char* name;
  std::vector<const char*> parts;  // of control names
};

// The first region that has a part of this name; throws std::runtime_error where none has.
const char* region_of(const std::string& control, const std::vector<Region>& regions);

}  // namespace rigs
