// Ears, drawn out of the skin by loops, and nostrils, pushed into it.
#include "face_mesh.h"
#include "head_shape.h"

namespace sample_face {
namespace {

// A loop of an ear in the ear's plane: centre (back, up, out) from the ear's middle and half sizes.
struct EarRing {
  float back, up, out, half_length, half_height;
};
constexpr EarRing kEar[] = {
    {-0.25f, 0.0f, 0.0f, 0.75f, 2.2f},                                       // base
    {0.20f, 0.2f, 0.55f, 0.95f, 2.45f}, {0.45f, 0.3f, 0.85f, 1.55f, 2.95f},  // back of the shell and rim
    {0.45f, 0.3f, 1.20f, 1.60f, 3.00f}, {0.40f, 0.3f, 1.25f, 1.25f, 2.60f},  // rim, front of the rim
    {0.30f, 0.2f, 0.90f, 0.98f, 2.15f}, {0.10f, -0.2f, 0.85f, 0.70f, 1.45f},
    {0.0f, -0.4f, 0.35f, 0.45f, 0.95f},  // hollow
};

}  // namespace

void add_ear_loops(FaceMesh& mesh, const Ring& outer, int a, int b, int side) {
  const Vec3 middle = hit_head({12, -1.2f, -0.9f}, {-1, 0, 0});
  const Vec3 back = unit({0.42f, 0.0f, -0.9f}), up = unit({0.05f, 1, -0.16f}), out = unit({0.9f, 0, 0.42f});
  Ring previous;
  for (const EarRing& e : kEar) {
    const bool base = &e == kEar;
    Ring ring;
    for (std::size_t i = 0; i < outer.size(); ++i) {
      // Round the ellipse by index, from the middle of the hole's left side; an ear is narrower at the lobe.
      const float angle = 2 * kPi * (float(i) + 0.5f * float(b)) / float(outer.size()) + kPi;
      const float s = std::sin(angle), c = std::cos(angle) * float(side);  // the grid's right is the left ear's back
      const float egg = 0.89f + 0.11f * s - 0.08f * std::max(0.0f, -s);
      const float hug = 1 - 0.55f * std::pow(std::max(0.0f, -s), 2.0f);  // the lobe lies close to the head
      Vec3 p =
          middle + back * (e.back + c * e.half_length * egg) + up * (e.up + s * e.half_height) + out * (e.out * hug);
      if (base) p = onto_head(p);
      if (side < 0) p = mirrored(p);
      if (base) mesh.points[outer[i]] = p;
      ring.push_back(base ? outer[i] : mesh.add(p));
    }
    if (!base) mesh.bridge(previous, ring);
    previous = ring;
  }
  mesh.cap(previous, a, b);
}

void add_nostril_loops(FaceMesh& mesh, const Ring& outer, int a, int b, int side) {
  // Ellipses seen from below, the second pair of numbers their half sizes; how deep they lie under the skin.
  struct Step {
    float x, z, half_x, half_z, depth;
  };
  constexpr Step kSteps[] = {{0.66f, 9.50f, 0.34f, 0.46f, 0},
                             {0.66f, 9.50f, 0.27f, 0.37f, -0.01f},
                             {0.65f, 9.58f, 0.25f, 0.33f, 0.25f},
                             {0.58f, 9.85f, 0.17f, 0.22f, 1.0f}};
  Ring previous;
  for (const Step& step : kSteps) {
    const bool rim = &step == kSteps;
    Ring ring;
    for (std::size_t i = 0; i < outer.size(); ++i) {
      // The grid's up runs forwards here, towards the tip; the nostrils close in on each other there.
      const float angle = 2 * kPi * float(i) / float(outer.size()) + radians(225);
      const float x = step.half_x * std::cos(angle) * float(side), z = step.half_z * std::sin(angle);
      Vec3 p = hit_head({step.x + x - 0.32f * z, -5.0f, step.z + z}, {0, 1, 0});
      p.y += step.depth;
      if (side < 0) p = mirrored(p);
      if (rim) mesh.points[outer[i]] = p;
      ring.push_back(rim ? outer[i] : mesh.add(p));
    }
    if (!rim) mesh.bridge(previous, ring);
    previous = ring;
  }
  mesh.cap(previous, a, b);
}

}  // namespace sample_face
