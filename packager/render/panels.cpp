#include "render/panels.h"

#include <algorithm>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/shading.h"
#include "render/text.h"

namespace fb {
namespace {

constexpr Rgb paper = {247, 247, 248}, ink = {38, 40, 46};
constexpr int gap = 8, bar_width = 22, bar_gap = 6, scale_magnification = 2;

void paste(Image& onto, const Image& image, int x, int y) {
  for (int row = 0; row < image.height; ++row) std::copy_n(&image.at(0, row), image.width, &onto.at(x, y + row));
}

// The numbers beside a bar, from 0 up.
std::vector<std::string> numbers_of_scale(float full) {
  constexpr int intervals = 4;
  std::vector<std::string> numbers = {"0"};
  for (int tick = 1; tick <= intervals; ++tick) numbers.push_back(format("%.3g", full * tick / intervals));
  return numbers;
}

int scale_width(float full) {
  int widest = 0;
  for (const std::string& number : numbers_of_scale(full))
    widest = std::max(widest, text_width(number, scale_magnification));
  return bar_width + bar_gap + widest + gap;
}

void draw_scale(Image& onto, int x, int y, int height, float full) {
  constexpr int magnification = scale_magnification;
  const int top = y + text_height(magnification), bottom = y + height - text_height(magnification);
  for (int row = top; row < bottom; ++row) {
    const Rgb colour = to_srgb(map_colour(full * (bottom - 1 - row) / (bottom - 1 - top), full));
    for (int column = 0; column < bar_width; ++column) onto.at(x + column, row) = colour;
  }
  const std::vector<std::string> numbers = numbers_of_scale(full);
  const int intervals = static_cast<int>(numbers.size()) - 1;
  for (int tick = 0; tick <= intervals; ++tick) {
    const int row = bottom - (bottom - top) * tick / intervals;
    draw_text(onto, x + bar_width + bar_gap, row - text_height(magnification) / 2, numbers[tick], ink, magnification);
  }
}

std::vector<std::string> lines_of(const std::string& caption) {
  std::vector<std::string> lines(1);
  for (const char c : caption)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  return lines;
}

}  // namespace

Image compose(const std::vector<Panel>& panels) {
  int width = gap, height = 0, magnification = 2;
  std::size_t lines = 1;
  for (const Panel& panel : panels) {
    width += panel.image.width + gap + (panel.scale_full ? scale_width(*panel.scale_full) : 0);
    height = std::max(height, panel.image.height);
    const std::vector<std::string> caption = lines_of(panel.caption);
    lines = std::max(lines, caption.size());
    for (const std::string& line : caption)  // smaller if a line would not fit
      if (text_width(line, magnification) > panel.image.width) magnification = 1;
  }
  const int line_height = text_height(magnification) + gap / 2;
  Image sheet(width, 3 * gap + height + static_cast<int>(lines) * line_height, paper);
  int x = gap;
  for (const Panel& panel : panels) {
    paste(sheet, panel.image, x, gap);
    int y = 2 * gap + height;
    for (const std::string& line : lines_of(panel.caption)) {
      const int indent = std::max(0, (panel.image.width - text_width(line, magnification)) / 2);
      draw_text(sheet, x + indent, y, line, ink, magnification);
      y += line_height;
    }
    x += panel.image.width + gap;
    if (panel.scale_full) {
      draw_scale(sheet, x, gap, height, *panel.scale_full);
      x += scale_width(*panel.scale_full);
    }
  }
  return sheet;
}

}  // namespace fb
