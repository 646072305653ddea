#pragma once

#include <string>

#include "render/image.h"

namespace fb::tool {

// Size in pixels of a line of printable ASCII at an integer magnification; other characters become '?'.
int text_width(const std::string& line, int magnification);
int text_height(int magnification);

// Draws a line with its upper left corner at (x, y), clipped to the image.
void draw_text(Image& image, int x, int y, const std::string& line, Rgb colour, int magnification);

}  // namespace fb::tool
