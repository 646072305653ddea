#include "support/regions.h"

#include <stdexcept>

namespace rigs {

const char* region_of(const std::string& control, const std::vector<Region>& regions) {
  for (const Region& region : regions) {
    for (const char* part : region.parts) {
      if (control.find(part) != std::string::npos) return region.name;
    }
  }
  throw std::runtime_error("control '" + control + "' belongs to no region of the face");
}

}  // namespace rigs
