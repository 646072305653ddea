#include "render/montage.h"

#include <algorithm>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/shading.h"
#include "render/text.h"

namespace fb::tool {
namespace {

constexpr Rgb background_colour = {247, 247, 248}, text_colour = {38, 40, 46};
constexpr int gap = 8, bar_width = 22, bar_gap = 6, label_magnification = 2;

void paste(Image& onto, const Image& image, int x, int y) {
  for (int row = 0; row < image.height; ++row) std::copy_n(&image.at(0, row), image.width, &onto.at(x, y + row));
}

// The labels of a colour bar, from its beginning up.
std::vector<std::string> tick_labels(const ColourBar& bar) {
  std::vector<std::string> labels;
  for (const float tick : bar.scale.ticks()) {
    labels.push_back(format(bar.scale.logarithmic ? "%.2g" : "%.3g", tick));
    if (!bar.units.empty()) labels.back() += format(" = %.2g %s", tick * bar.length, bar.units.c_str());
  }
  return labels;
}

int colour_bar_width(const ColourBar& bar) {
  int widest = 0;
  for (const std::string& label : tick_labels(bar)) widest = std::max(widest, text_width(label, label_magnification));
  return bar_width + bar_gap + widest + gap;
}

void draw_colour_bar(Image& onto, int x, int y, int height, const ColourBar& bar) {
  constexpr int magnification = label_magnification;
  const int top = y + text_height(magnification), bottom = y + height - text_height(magnification);
  for (int row = top; row < bottom; ++row) {
    const float share = static_cast<float>(bottom - 1 - row) / static_cast<float>(bottom - 1 - top);
    const Rgb colour = to_srgb(map_colour(share, {}));  // colours are even along the bar, labels need not be
    for (int column = 0; column < bar_width; ++column) onto.at(x + column, row) = colour;
  }
  const std::vector<std::string> labels = tick_labels(bar);
  const int intervals = static_cast<int>(labels.size()) - 1;
  for (int tick = 0; tick <= intervals; ++tick) {
    const int row = bottom - (bottom - top) * tick / intervals;
    draw_text(onto, x + bar_width + bar_gap, row - text_height(magnification) / 2, labels[tick], text_colour,
              magnification);
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

Image make_montage(const std::vector<Panel>& panels) {
  int width = gap, height = 0, magnification = 2;
  std::size_t lines = 1;
  for (const Panel& panel : panels) {
    width += panel.image.width + gap + (panel.bar ? colour_bar_width(*panel.bar) : 0);
    height = std::max(height, panel.image.height);
    const std::vector<std::string> caption = lines_of(panel.caption);
    lines = std::max(lines, caption.size());
    for (const std::string& line : caption)  // smaller if a line would not fit
      if (text_width(line, magnification) > panel.image.width) magnification = 1;
  }
  const int line_height = text_height(magnification) + gap / 2;
  Image montage(width, 3 * gap + height + static_cast<int>(lines) * line_height, background_colour);
  int x = gap;
  for (const Panel& panel : panels) {
    paste(montage, panel.image, x, gap);
    int y = 2 * gap + height;
    for (const std::string& line : lines_of(panel.caption)) {
      const int indent = std::max(0, (panel.image.width - text_width(line, magnification)) / 2);
      draw_text(montage, x + indent, y, line, text_colour, magnification);
      y += line_height;
    }
    x += panel.image.width + gap;
    if (panel.bar) {
      draw_colour_bar(montage, x, gap, height, *panel.bar);
      x += colour_bar_width(*panel.bar);
    }
  }
  return montage;
}

}  // namespace fb::tool
