#include "render/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/shading.h"

namespace fb::tool {
namespace {

constexpr int decades = 3;

}  // namespace

float ColourScale::position(float value) const {
  if (!(end > 0) || !(value > 0)) return 0;
  const float share = value / end;
  return std::clamp(logarithmic ? 1 + std::log10(share) / decades : share, 0.0f, 1.0f);
}

std::vector<float> ColourScale::ticks() const {
  if (!logarithmic) return {0, end / 4, end / 2, end * 3 / 4, end};
  std::vector<float> ticks;
  for (int decade = decades; decade >= 0; --decade) {
    const float tick = end / std::pow(10.0f, static_cast<float>(decade));
    ticks.push_back(tick);
    if (decade > 0) ticks.push_back(tick * std::sqrt(10.0f));
  }
  return ticks;
}

Rgb part_colour(std::size_t part) {
  static constexpr std::array<Rgb, 12> colours = {{{230, 85, 45},
                                                   {45, 125, 210},
                                                   {60, 165, 75},
                                                   {155, 80, 190},
                                                   {240, 175, 40},
                                                   {20, 160, 165},
                                                   {215, 75, 140},
                                                   {135, 100, 60},
                                                   {130, 190, 60},
                                                   {90, 90, 200},
                                                   {185, 45, 45},
                                                   {120, 150, 175}}};
  return colours[part % colours.size()];
}

Vector3 map_colour(float value, const ColourScale& scale) {
  static constexpr std::array<Vector3, 6> stops = {{{0.90f, 0.91f, 0.92f},
                                                    {0.96f, 0.84f, 0.42f},
                                                    {0.97f, 0.64f, 0.20f},
                                                    {0.87f, 0.33f, 0.20f},
                                                    {0.60f, 0.11f, 0.33f},
                                                    {0.20f, 0.02f, 0.30f}}};
  const float position = scale.position(value) * (stops.size() - 1);
  const std::size_t below = std::min<std::size_t>(static_cast<std::size_t>(position), stops.size() - 2);
  return from_srgb(mix(stops[below], stops[below + 1], position - static_cast<float>(below)));
}

float round_scale(float value) {
  double decade = 1e-6;
  while (decade < 1e30) {
    for (const double step : {1.0, 2.0, 5.0})
      if (step * decade >= value) return static_cast<float>(step * decade);
    decade *= 10;
  }
  return value;
}

}  // namespace fb::tool
