#include "render/text.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop

namespace fb::tool {
namespace {

std::string printable(std::string line) {
  for (char& c : line)
    if (c < 32 || c > 126) c = '?';
  return line;
}

}  // namespace

int text_width(const std::string& line, int magnification) {
  std::string text = printable(line);
  return stb_easy_font_width(text.data()) * magnification;
}

int text_height(int magnification) {
  return 10 * magnification;
}

void draw_text(Image& image, int x, int y, const std::string& line, Rgb colour, int magnification) {
  // The font comes as axis-aligned quads on a pixel grid: four vertices of three floats and a colour each.
  struct Vertex {
    float x, y, z;
    unsigned char colour[4];
  };
  static_assert(sizeof(Vertex) == 16);
  std::string text = printable(line);
  std::vector<Vertex> corners(4 * 40 * (text.size() + 1));
  const int quads = stb_easy_font_print(0, 0, text.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Vertex)));
  for (int q = 0; q < quads; ++q) {
    const Vertex &low = corners[4 * q], &high = corners[4 * q + 2];
    const auto pixels = [&](float unit) { return static_cast<int>(std::lround(unit * magnification)); };
    for (int py = std::max(0, y + pixels(low.y)); py < std::min(image.height, y + pixels(high.y)); ++py)
      for (int px = std::max(0, x + pixels(low.x)); px < std::min(image.width, x + pixels(high.x)); ++px)
        image.at(px, py) = colour;
  }
}

}  // namespace fb::tool
