#include "render/appearance.h"

namespace fb::tool {

Appearance::Seen Appearance::at(std::size_t triangle, float b, float c) const {
  const SurfaceColour& surface = colours[of_triangle[triangle]];
  if (!surface.texture || uvs.empty()) return {surface.colour, surface.emissive, surface.alpha >= surface.least_alpha};
  const float* uv = &uvs[6 * triangle];
  const float a = 1 - b - c;
  const auto [red, green, blue, alpha] = textures[*surface.texture].at(
      a * uv[0] + b * uv[2] + c * uv[4], a * uv[1] + b * uv[3] + c * uv[5], surface.wrap_u, surface.wrap_v);
  return {surface.colour * Vector3{red, green, blue}, surface.emissive, alpha * surface.alpha >= surface.least_alpha};
}

}  // namespace fb::tool
