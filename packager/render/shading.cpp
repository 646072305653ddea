#include "render/shading.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

struct Light {
  Vector3 direction;  // towards it, camera space
  Vector3 colour;
  float wrap;  // wrap lighting: how far beyond 90 degrees it reaches, as an area light does
};

// Key light from the upper left, weaker cool fill light from the right, two rim lights from behind.
const Light lights[] = {
    {normalized({-0.55f, 0.60f, 0.65f}), {1.18f, 1.10f, 1.00f}, 0.15f},
    {normalized({0.85f, 0.05f, 0.55f}), {0.22f, 0.26f, 0.32f}, 0.30f},
    {normalized({0.75f, 0.45f, -0.65f}), {0.55f, 0.58f, 0.65f}, 0.0f},
    {normalized({-0.85f, 0.30f, -0.60f}), {0.30f, 0.30f, 0.32f}, 0.0f},
};

}  // namespace

Vector3 shade_clay(Vector3 normal, Vector3 to_eye, float ambient_occlusion, Vector3 colour) {
  const float sky = 0.5f + 0.5f * normal.y;
  Vector3 diffuse = mix(Vector3{0.10f, 0.085f, 0.08f}, Vector3{0.19f, 0.21f, 0.24f}, sky);
  Vector3 specular;
  for (const Light& light : lights) {
    const float cosine = (dot(normal, light.direction) + light.wrap) / (1 + light.wrap);
    if (cosine <= 0) continue;
    diffuse = diffuse + light.colour * cosine;
    // Specular lobe of Blinn (1977), broad: skin is rough.
    const float half = std::max(0.0f, dot(normal, normalized(light.direction + to_eye)));
    const float h4 = half * half * half * half, h16 = h4 * h4 * h4 * h4;
    specular = specular + light.colour * (0.09f * h16 * h4 * cosine);
  }
  // The lights are large, so ambient occlusion dims them too.
  return (colour * diffuse + specular) * (0.04f + 0.96f * ambient_occlusion);
}

Vector3 shade_colour_map(Vector3 normal, float ambient_occlusion, Vector3 colour) {
  const float cosine = std::max(0.0f, dot(normal, lights[0].direction));
  return colour * (0.40f + 0.25f * ambient_occlusion + 0.35f * cosine);
}

Vector3 background(float t) {
  return mix(Vector3{0.16f, 0.18f, 0.21f}, Vector3{0.42f, 0.44f, 0.46f}, t * t * (3 - 2 * t));
}

Vector3 from_srgb(Vector3 c) {
  const auto channel = [](float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); };
  return {channel(c.x), channel(c.y), channel(c.z)};
}

Rgb to_srgb(Vector3 c) {
  const auto channel = [](float l) {
    l = std::clamp(l, 0.0f, 1.0f);
    const float s = l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
    return static_cast<std::uint8_t>(std::lround(255 * s));
  };
  return {channel(c.x), channel(c.y), channel(c.z)};
}

}  // namespace fb::tool
