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
  const int count = int(outer.size());
  Ring previous;
  for (const EarRing& e : kEar) {
    Ring ring;
    for (int i = 0; i < count; ++i) {
      // Walk the hole's rectangle as an ellipse: corner to corner, evenly by index.
      const float along = (float(i) + 0.5f * float(b)) / float(count);  // 0 in the middle of the left side
      (void)a;
      float angle = 2 * kPi * along + kPi;
      if (side < 0) angle = angle;
      const float c = std::cos(angle), s = std::sin(angle);
      // Egg: narrower at the lobe. On the left ear the grid's right is the ear's back.
      const float egg = 1 - 0.22f * (1 - s) * 0.5f - 0.08f * std::max(0.0f, -s);
      const float x = (side > 0 ? c : -c) * e.half_length * egg;
      Vec3 p = middle + back * (e.back + x) + up * (e.up + s * e.half_height) + out * e.out;
      if (&e == &kEar[0]) p = onto_head(p);
      if (side < 0) p = mirrored(p);
      if (&e == &kEar[0]) {
        mesh.points[outer[i]] = p;
        ring.push_back(outer[i]);
      } else {
        ring.push_back(mesh.add(p));
      }
    }
    if (!previous.empty()) mesh.bridge(previous, ring);
    previous = ring;
  }
  mesh.cap(previous, a, b);
}

void add_nostril_loops(FaceMesh& mesh, const Ring& outer, int a, int b, int side) {
  struct Step {
    Vec3 centre, radii;
  };
  constexpr Step kSteps[] = {{{0.62f, -4.42f, 9.35f}, {0.34f, 0, 0.55f}},
                             {{0.63f, -4.1f, 9.35f}, {0.27f, 0, 0.45f}},
                             {{0.6f, -3.4f, 9.2f}, {0.2f, 0, 0.35f}}};
  Ring previous;
  for (const Step& step : kSteps) {
    Ring ring;
    for (std::size_t i = 0; i < outer.size(); ++i) {
      const float angle = 2 * kPi * float(i) / float(outer.size()) + radians(225);
      // Seen from below and in front: the grid's up is forwards, towards the tip.
      Vec3 p = step.centre + Vec3{step.radii.x * std::cos(angle) * float(side), 0, step.radii.z * std::sin(angle)};
      p.x -= 0.25f * (p.z - step.centre.z) * 1.0f;
      if (side < 0) p = p;
      if (&step == &kSteps[0]) p = onto_head(p);
      if (side < 0) p = mirrored(p);
      if (&step == &kSteps[0]) {
        mesh.points[outer[i]] = p;
        ring.push_back(outer[i]);
      } else {
        ring.push_back(mesh.add(p));
      }
    }
    if (!previous.empty()) mesh.bridge(previous, ring);
    previous = ring;
  }
  mesh.cap(previous, a, b);
}

}  // namespace sample_face
