#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/image.h"

namespace fb::tool {

struct Panel {
  Image image;
  std::string caption;             // lines are separated by \n
  std::optional<float> scale_max;  // a colour bar of map_colour from 0 to this value stands on the right; none: no bar
};

// Images of one height side by side, in order, with their captions below.
Image make_montage(const std::vector<Panel>& panels);

}  // namespace fb::tool
