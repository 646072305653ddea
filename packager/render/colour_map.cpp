#include "render/colour_map.h"

#include <algorithm>
#include <array>

#include "render/shading.h"

namespace fb::tool {

Vector3 map_colour(float value, float scale_max) {
  static constexpr std::array<Vector3, 6> stops = {{{0.90f, 0.91f, 0.92f},
                                                    {0.96f, 0.84f, 0.42f},
                                                    {0.97f, 0.64f, 0.20f},
                                                    {0.87f, 0.33f, 0.20f},
                                                    {0.60f, 0.11f, 0.33f},
                                                    {0.20f, 0.02f, 0.30f}}};
  const float position = std::clamp(scale_max > 0 ? value / scale_max : 0.0f, 0.0f, 1.0f) * (stops.size() - 1);
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
