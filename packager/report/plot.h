// Plots as inline SVG, and bar charts as HTML.
#pragma once

#include <string>
#include <vector>

namespace fb::tool {

struct Curve {
  std::string name;
  std::vector<double> x, y;  // equally long; on a logarithmic scale, points that are not above 0 are left out
  int colour = 0;            // one of eight, modulo 8; 0 is grey
  bool dotted = false;
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  bool log_x = false, log_y = true;
  int width = 560, height = 300;
};

// SVG; empty if there is no point. Of several points in one column of pixels the largest is drawn. On a logarithmic
// scale the lowest tenth of a curve's values does not extend the range and may be clamped to its edge.
std::string draw_plot(const Plot& plot);

struct Bar {
  std::string name;
  std::vector<double> values;  // one a series
};

// HTML of horizontal bars labelled with their values; series: names, colours: one of each series. A logarithmic scale
// spans at most twelve decades below the largest value.
std::string draw_bars(const std::vector<std::string>& series, const std::vector<int>& colours,
                      const std::vector<Bar>& bars, bool logarithmic);

}  // namespace fb::tool
