#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/colour_map.h"
#include "render/image.h"

namespace fb::tool {

// A legend of map_colour. Labels are the values, and what they are in `units` where these have a name.
struct ColourBar {
  ColourScale scale;
  double length = 0;       // of 1, in units
  std::string units = "";  // "cm"
};

struct Panel {
  Image image;
  std::string caption;           // lines are separated by \n
  std::optional<ColourBar> bar;  // stands on the right; none: no bar
};

// Images of one height side by side, in order, with their captions below.
Image make_montage(const std::vector<Panel>& panels);

}  // namespace fb::tool
