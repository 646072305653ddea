#include "report/coverage_pictures.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/shading.h"
#include "report/html.h"

namespace fb::tool {
namespace {

constexpr int square_pixels = 640, largest_cell = 24;
constexpr Rgb never = {120, 160, 205}, diagonal_colour = {247, 247, 248};

// A part of a row, from one percentage to another.
std::string part_of_row(double from, double to, const char* colour) {
  return format(
      "<span style=\"position:absolute;height:.7rem;left:%.2f%%;width:max(3px,%.2f%%);background:%s\"></span>", from,
      to - from, colour);
}

}  // namespace

std::string draw_ranges(const std::vector<UsedRange>& controls) {
  std::string html =
      "<div class=\"bars\">\n<span class=\"key\"><span class=\"swatch\" style=\"background:var(--c2)\">"
      "</span>used</span>\n<span class=\"key\"><span class=\"swatch\" style=\"background:var(--line)\">"
      "</span>not used</span>\n<span class=\"key\"><span class=\"swatch\" style=\"background:var(--c1)\">"
      "</span>default</span>\n";
  for (const UsedRange& control : controls) {
    const double size = double(control.maximum) - control.minimum;
    if (!std::isfinite(control.lowest) || !(size > 0)) continue;
    const auto percent = [&](double value) { return std::clamp(100 * (value - control.minimum) / size, 0.0, 100.0); };
    const std::string words = format("%s: %.3g to %.3g of %.3g to %.3g", control.name.c_str(), control.lowest,
                                     control.highest, control.minimum, control.maximum);
    html += "<div class=\"bar\" title=\"" + escape_html(words) + "\"><span class=\"name\">" +
            escape_html(control.name) + "</span><div style=\"position:relative;height:.7rem;background:var(--line)\">" +
            part_of_row(percent(control.lowest), percent(control.highest), "var(--c2)") +
            part_of_row(percent(control.rest), percent(control.rest), "var(--c1)") + "</div></div>\n";
  }
  return html + "</div>\n";
}

Image draw_pairs(const std::vector<float>& pair_shares, std::size_t controls) {
  float most = 0;
  for (std::size_t a = 0; a < controls; ++a)
    for (std::size_t b = 0; b < controls; ++b)
      if (a != b) most = std::max(most, pair_shares[a * controls + b]);
  const ColourScale scale{round_scale(100 * most), true};  // percent of the poses
  const int cell = std::clamp(square_pixels / static_cast<int>(controls), 1, largest_cell);
  Image square(cell * static_cast<int>(controls), cell * static_cast<int>(controls), never);
  for (int y = 0; y < square.height; ++y)
    for (int x = 0; x < square.width; ++x) {
      const auto a = static_cast<std::size_t>(y / cell), b = static_cast<std::size_t>(x / cell);
      const float share = pair_shares[a * controls + b];
      if (a == b)
        square.at(x, y) = diagonal_colour;
      else if (share > 0)
        square.at(x, y) = to_srgb(map_colour(100 * share, scale));
    }
  return make_montage({{square, "percent of the poses; blue: never", ColourBar{scale, 0, ""}}});
}

}  // namespace fb::tool
