#pragma once

#include <string>

#include "render/image.h"

namespace fb {

// Size in pixels of one line of printable ASCII at a magnification; other characters are shown as '?'.
int text_width(const std::string& line, int magnification);
int text_height(int magnification);

// Draws with the upper left corner at (x, y); what lies outside the picture is cut off.
void draw_text(Image& image, int x, int y, const std::string& line, Rgb colour, int magnification);

}  // namespace fb
