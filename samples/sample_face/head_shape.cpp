#include "head_shape.h"

#include "anatomy.h"

namespace sample_face {
namespace {

// Smooth minimum: blends two surfaces over a distance k.
float blend(float a, float b, float k) {
  const float h = std::max(k - std::fabs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}

// a with b taken away, the edge rounded over k.
float carve(float a, float b, float k) {
  return -blend(-a, b, k);
}

float ball(Vec3 p, Vec3 centre, float radius) {
  return length(p - centre) - radius;
}

// Bound of the distance to an ellipsoid, exact on the surface.
float ellipsoid(Vec3 p, Vec3 centre, Vec3 radii) {
  const Vec3 d = p - centre;
  const Vec3 q{d.x / radii.x, d.y / radii.y, d.z / radii.z};
  const Vec3 g{q.x / radii.x, q.y / radii.y, q.z / radii.z};
  const float k = length(q), m = length(g);
  return m > 1e-6f ? k * (k - 1) / m : -std::min({radii.x, radii.y, radii.z});
}

// A cone with round ends: radius ra at a, rb at b.
float limb(Vec3 p, Vec3 a, Vec3 b, float ra, float rb) {
  const Vec3 ab = b - a;
  const float t = clamp01(dot(p - a, ab) / dot(ab, ab));
  return length(p - a - ab * t) - mix(ra, rb, t);
}

// How far the eyebrow stands out: a ridge along an arc over the eye, thick near the nose, fine at the temple.
float eyebrow(Vec3 p) {
  if (p.z < 3) return 0;
  const float t = clamp01((p.x - 1.2f) / 4.3f);  // along the arc
  const float arc = 3.0f + 0.75f * std::sin(kPi * std::pow(t, 0.85f)) - 0.15f * t;
  const float across = (p.y - arc) / mix(0.55f, 0.38f, t);
  const float past = std::max({0.0f, 1.3f - p.x, p.x - 5.5f}) / 0.6f;
  return (0.26f + 0.12f * std::sin(kPi * std::min(1.0f, t + 0.15f))) * std::exp(-across * across - past * past);
}

}  // namespace

float head_distance(Vec3 p) {
  p.x = std::fabs(p.x);
  float d = ellipsoid(p, {0, 3.0f, -1.2f}, {7.4f, 8.2f, 8.6f});                       // cranium
  d = blend(d, ellipsoid(p, {0, 2.6f, 2.2f}, {6.2f, 5.9f, 6.3f}), 2.0f);              // forehead
  d = blend(d, ellipsoid(p, {0, -4.6f, 1.9f}, {5.7f, 5.9f, 6.0f}), 2.6f);             // middle face
  d = blend(d, limb(p, {4.9f, -5.6f, 0.2f}, {1.7f, -9.3f, 5.3f}, 1.2f, 1.6f), 2.4f);  // jaw
  d = blend(d, ellipsoid(p, {0, -9.7f, 6.6f}, {1.6f, 1.45f, 1.75f}), 1.6f);           // chin
  d = blend(d, ball(p, {3.75f, -3.0f, 5.0f}, 2.5f), 1.9f);                            // cheekbones
  d = blend(d, ellipsoid(p, {0, -6.8f, 5.6f}, {3.0f, 2.5f, 2.75f}), 1.9f);            // over the teeth
  d = blend(d, limb(p, {1.2f, 2.45f, 7.1f}, {4.9f, 2.6f, 4.9f}, 0.95f, 0.9f), 1.5f);  // brow ridge
  d = blend(d, ellipsoid(p, {0, 2.9f, 7.0f}, {1.7f, 1.5f, 1.25f}), 1.4f);             // between the brows
  d = blend(d, limb(p, {0, -9.0f, -2.2f}, {0, -18.5f, -3.2f}, 4.0f, 4.3f), 2.4f);     // neck
  d = carve(d, ellipsoid(p, {kEyeCentre.x, 0.1f, 8.75f}, {2.3f, 1.8f, 1.8f}), 1.6f);  // sockets
  d = carve(d, ball(p, {0, -8.55f, 9.7f}, 0.8f), 1.3f);                               // under the lower lip
  d = blend(d, ball(p, kEyeCentre, kEyeRadius + kLidThickness), 0.55f);               // lids over the eyeballs
  d -= eyebrow(p);
  float nose = limb(p, {0, 1.3f, 7.6f}, {0, -3.0f, 9.6f}, 0.6f, 0.85f);                    // bridge
  nose = blend(nose, ellipsoid(p, {0, -3.4f, 9.75f}, {1.12f, 0.98f, 1.05f}), 0.8f);        // tip
  nose = blend(nose, ellipsoid(p, {1.14f, -3.78f, 8.95f}, {0.72f, 0.70f, 0.95f}), 0.45f);  // wings
  d = blend(d, nose, 0.9f);
  return carve(d, limb(p, {0, -4.95f, 9.5f}, {0, -5.9f, 9.2f}, 0.2f, 0.3f), 0.5f);  // philtrum
}

Vec3 head_normal(Vec3 p) {
  constexpr float h = 0.02f;
  return unit({head_distance({p.x + h, p.y, p.z}) - head_distance({p.x - h, p.y, p.z}),
               head_distance({p.x, p.y + h, p.z}) - head_distance({p.x, p.y - h, p.z}),
               head_distance({p.x, p.y, p.z + h}) - head_distance({p.x, p.y, p.z - h})});
}

Vec3 onto_head(Vec3 p) {
  for (int step = 0; step < 2; ++step) p -= head_normal(p) * (head_distance(p) * 0.95f);
  return p;
}

Vec3 hit_head(Vec3 from, Vec3 direction) {
  for (int step = 0; step < 40; ++step) {
    const float d = head_distance(from);
    if (d < 1e-3f) break;
    from += direction * (d * 0.8f);
  }
  return from;
}

}  // namespace sample_face
