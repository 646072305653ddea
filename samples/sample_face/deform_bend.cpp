#include "motion.h"

namespace sample_face {
namespace {

constexpr float kTop = -1.9f;  // above this height nothing moves

}  // namespace

Bend::Bend(const FaceMesh& mesh) {
  for (Index v = 0; v < mesh.points.size(); ++v) {
    const Vec3 p = mesh.points[v];
    const float weight = smoothstep(kTop, -10.0f, p.y) * smoothstep(-16.5f, -11.5f, p.y) * smoothstep(-5.5f, 3.5f, p.z);
    if (weight > 1e-4f) moved_.push_back({v, weight});
  }
}

void Bend::pose(const MotionControls& m, const float* c, Vec3* points) const {
  const float squash = c[m.squash], bend = radians(9) * c[m.bend];
  if (squash == 0 && bend == 0) return;
  for (const Weighted& w : moved_) {
    Vec3& p = points[w.vertex];
    const float stretch = -1.0f * squash * w.weight;
    p.x *= 1 - 0.09f * stretch * (1 + 0.3f * stretch);  // what gets longer gets thinner
    p.y += -stretch;
    const float a = bend * w.weight, sine = a - a * a * a / 6, drop = a * a / 2;
    const float x = p.x, y = p.y - kTop;
    p.x += -y * sine - x * drop;
    p.y += x * sine - y * drop;
  }
}

}  // namespace sample_face
