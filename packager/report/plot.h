// Curves and bars as SVG that a page holds within itself.
#pragma once

#include <string>
#include <vector>

namespace fb::tool {

struct Curve {
  std::string name;
  std::vector<double> x, y;  // as many of each; with a logarithmic scale, points that are not above 0 are left out
  int colour = 0;            // one of eight: 0 is grey; taken modulo 8
  bool dotted = false;
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  bool log_x = false, log_y = true;
  int width = 560, height = 300;
};

// Curves of more points than the plot is wide are drawn by the largest of each column. Where y is logarithmic, a
// curve's lowest tenth does not stretch the scale and may lie on its edge. Empty if there is no point.
std::string draw_plot(const Plot& plot);

struct Bar {
  std::string name;
  std::vector<double> values;  // one a series
};

// A list of bars, each with its numbers; series are named and coloured alike throughout. A logarithmic scale spans at
// most twelve decades below the largest value.
std::string draw_bars(const std::vector<std::string>& series, const std::vector<int>& colours,
                      const std::vector<Bar>& bars, bool logarithmic);

}  // namespace fb::tool
