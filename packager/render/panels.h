#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/image.h"

namespace fb {

struct Panel {
  Image image;
  std::string caption;              // lines end at a \n
  std::optional<float> scale_full;  // with a value: a bar of map_colour from 0 to it stands beside the picture
};

// Pictures side by side, in order, captions below. All images have one height.
Image compose(const std::vector<Panel>& panels);

}  // namespace fb
