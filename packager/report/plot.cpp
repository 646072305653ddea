#include "report/plot.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "report/html.h"

namespace fb::tool {
namespace {

constexpr double decades_at_most = 12;

std::string colour_of(int colour) {
  return "var(--c" + std::to_string(colour % 8) + ")";
}

std::string text_at(double x, double y, const char* anchor, const std::string& words, const char* more = "") {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" %s>", x, y, anchor, more) + escape_html(words) +
         "</text>\n";
}

// Maps values to pixels.
struct Axis {
  bool logarithmic = false;
  double low = 0, high = 1;   // of the value, or of its decimal logarithm
  double from = 0, to = 1;    // pixels, or percent
  std::vector<double> ticks;  // values

  bool shows(double value) const { return std::isfinite(value) && (!logarithmic || value > 0); }
  double pixel(double value) const {
    const double v = logarithmic ? std::log10(value) : value;
    return from + (std::clamp(v, low, high) - low) / (high - low) * (to - from);
  }
};

void add_ticks(Axis& axis) {
  if (axis.logarithmic) {
    const int first = static_cast<int>(std::ceil(axis.low - 1e-9)),
              last = static_cast<int>(std::floor(axis.high + 1e-9));
    const int step = std::max(1, (last - first + 5) / 6);
    for (int decade = first; decade <= last; decade += step) axis.ticks.push_back(std::pow(10.0, decade));
    return;
  }
  const double raw = (axis.high - axis.low) / 5, decade = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = raw / decade <= 1   ? decade
                      : raw / decade <= 2 ? 2 * decade
                      : raw / decade <= 5 ? 5 * decade
                                          : 10 * decade;
  for (double tick = std::ceil(axis.low / step - 1e-9) * step; tick <= axis.high + 1e-9 * step; tick += step)
    axis.ticks.push_back(tick + 0.0);  // no -0
}

Axis axis_over(const std::vector<double>& values, bool logarithmic) {
  Axis axis;
  axis.logarithmic = logarithmic;
  axis.low = INFINITY;
  axis.high = -INFINITY;
  for (const double value : values) {
    if (!axis.shows(value)) continue;
    axis.low = std::min(axis.low, logarithmic ? std::log10(value) : value);
    axis.high = std::max(axis.high, logarithmic ? std::log10(value) : value);
  }
  if (!(axis.low <= axis.high)) return axis;
  if (logarithmic) {
    axis.high = std::ceil(axis.high - 1e-9);
    axis.low = std::max(std::floor(axis.low + 1e-9), axis.high - decades_at_most);
  }
  if (axis.high - axis.low < 1e-12 * std::max(1.0, std::abs(axis.high))) axis.high = axis.low + 1;
  add_ticks(axis);
  return axis;
}

std::string number(double value) {
  if (value != 0 && (std::abs(value) < 1e-2 || std::abs(value) >= 1e6)) return format("%.0e", value);
  return format("%g", value);
}

std::string line_of(const Curve& curve, const Axis& x, const Axis& y) {
  std::string points;
  double column = -1, best_x = 0, best_y = INFINITY;
  const auto flush = [&] {
    if (column >= 0) points += format("%.1f,%.1f ", best_x, best_y);
    best_y = INFINITY;
  };
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!x.shows(curve.x[i]) || !y.shows(curve.y[i])) continue;
    const double px = x.pixel(curve.x[i]), py = y.pixel(curve.y[i]);
    if (std::floor(px) != column) {
      flush();
      column = std::floor(px);
    }
    if (py < best_y) {
      best_x = px;
      best_y = py;
    }
  }
  flush();
  if (points.empty()) return "";
  return "<polyline points=\"" + points + "\" style=\"stroke:" + colour_of(curve.colour) +
         (curve.dotted ? ";stroke-dasharray:2 4" : "") + "\"><title>" + escape_html(curve.name) +
         "</title></polyline>\n";
}

// Without the lowest tenth of the values, so that a few frames at rest do not compress the rest of the scale.
std::vector<double> without_lowest(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10));
  return values;
}

// Of an entry, with a name of so many letters.
double legend_width(std::size_t letters) {
  return 34 + 7.0 * static_cast<double>(letters);
}

}  // namespace

std::string draw_plot(const Plot& plot) {
  std::vector<double> xs, ys;
  for (const Curve& curve : plot.curves) {
    xs.insert(xs.end(), curve.x.begin(), curve.x.end());
    const std::vector<double> high = plot.log_y ? without_lowest(curve.y) : curve.y;
    ys.insert(ys.end(), high.begin(), high.end());
  }
  Axis x = axis_over(xs, plot.log_x), y = axis_over(ys, plot.log_y);
  if (!(x.low <= x.high) || !(y.low <= y.high)) return "";
  constexpr double left = 62, right = 12, top = 26, bottom = 44, row = 18;
  std::vector<const Curve*> named;
  for (const Curve& curve : plot.curves)
    if (!curve.name.empty()) named.push_back(&curve);
  std::size_t longest = 0;
  for (const Curve* curve : named) longest = std::max(longest, curve->name.size());
  const double column = legend_width(longest), columns = std::max(1.0, std::floor((plot.width - left) / column));
  const double legend = named.size() > 1 ? std::ceil(static_cast<double>(named.size()) / columns) * row : 0;
  const double height = plot.height + legend;
  x.from = left;
  x.to = plot.width - right;
  y.from = plot.height - bottom;
  y.to = top;

  std::string svg = format(
      "<div class=\"wide\" tabindex=\"0\"><svg viewBox=\"0 0 %d %.0f\" width=\"%d\" height=\"%.0f\" role=\"img\">\n",
      plot.width, height, plot.width, height);
  svg += "<title>" + escape_html(plot.title) + "</title>\n";
  svg += text_at(left, 16, "start", plot.title, "font-weight=\"600\"");
  for (const double tick : y.ticks) {
    svg += format("<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>\n", x.from, x.to,
                  y.pixel(tick), y.pixel(tick));
    svg += text_at(left - 6, y.pixel(tick) + 4, "end", number(tick));
  }
  for (const double tick : x.ticks) {
    svg += format("<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>\n", x.pixel(tick),
                  x.pixel(tick), y.from, y.to);
    svg += text_at(x.pixel(tick), y.from + 16, "middle", number(tick));
  }
  svg += format("<rect class=\"frame\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n", left, top,
                x.to - x.from, y.from - y.to);
  svg += text_at((x.from + x.to) / 2, y.from + 34, "middle", plot.x_label, "class=\"faint\"");
  svg += text_at(x.to, 16, "end", plot.y_label, "class=\"faint\"");
  for (const Curve& curve : plot.curves) svg += line_of(curve, x, y);
  for (std::size_t i = 0; legend > 0 && i < named.size(); ++i) {
    const double lx = left + column * std::fmod(static_cast<double>(i), columns);
    const double ly = plot.height + row * std::floor(static_cast<double>(i) / columns) + 8;
    svg +=
        format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" style=\"stroke:%s;stroke-width:3%s\"/>\n", lx,
               lx + 18, ly, ly, colour_of(named[i]->colour).c_str(), named[i]->dotted ? ";stroke-dasharray:2 4" : "");
    svg += text_at(lx + 24, ly + 4, "start", named[i]->name);
  }
  return svg + "</svg></div>\n";
}

std::string draw_bars(const std::vector<std::string>& series, const std::vector<int>& colours,
                      const std::vector<Bar>& bars, bool logarithmic) {
  std::vector<double> values = {};
  for (const Bar& bar : bars) values.insert(values.end(), bar.values.begin(), bar.values.end());
  if (!logarithmic) values.push_back(0);
  Axis axis = axis_over(values, logarithmic);
  if (bars.empty() || !(axis.low <= axis.high)) return "";
  axis.to = 75;  // percent of the space beside the names; the rest is for the values
  std::string html = "<div class=\"bars\">\n";
  for (std::size_t s = 0; s < series.size(); ++s)
    html += "<span class=\"key\"><span class=\"swatch\" style=\"background:" + colour_of(colours[s]) + "\"></span>" +
            escape_html(series[s]) + "</span>\n";
  for (const Bar& bar : bars) {
    html += "<div class=\"bar\"><span class=\"name\">" + escape_html(bar.name) + "</span><div>";
    for (std::size_t s = 0; s < bar.values.size(); ++s) {
      const double end = axis.shows(bar.values[s]) ? axis.pixel(bar.values[s]) - axis.from : 0;
      const std::string value = format("%.3g", bar.values[s]);
      html += "<div class=\"line\" title=\"" + escape_html(bar.name + ": " + value + " " + series[s]) + "\">" +
              format("<span style=\"width:%.1f%%;background:%s\"></span><span>", end, colour_of(colours[s]).c_str()) +
              value + "</span></div>";
    }
    html += "</div></div>\n";
  }
  return html + "</div>\n";
}

}  // namespace fb::tool
