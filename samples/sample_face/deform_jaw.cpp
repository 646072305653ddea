#include "anatomy.h"
#include "motion.h"

namespace sample_face {

Motion motion_about(Vec3 pivot, float pitch, float yaw, float roll, Vec3 slide) {
  const float cp = std::cos(pitch), sp = std::sin(pitch), cy = std::cos(yaw), sy = std::sin(yaw);
  const float cr = std::cos(roll), sr = std::sin(roll);
  Motion m;
  // Rz(roll) * Ry(yaw) * Rx(pitch)
  m.rows = {{{cr * cy, cr * sy * sp - sr * cp, cr * sy * cp + sr * sp},
             {sr * cy, sr * sy * sp + cr * cp, sr * sy * cp - cr * sp},
             {-sy, cy * sp, cy * cp}}};
  m.shift = pivot - m.turn(pivot) + slide;
  return m;
}

Motion operator*(const Motion& a, const Motion& b) {
  Motion m;
  for (int i = 0; i < 3; ++i) m.rows[i] = b.rows[0] * a.rows[i].x + b.rows[1] * a.rows[i].y + b.rows[2] * a.rows[i].z;
  m.shift = a(b.shift);
  return m;
}

Jaw::Jaw(const FaceMesh& mesh, const std::vector<float>& weights) {
  for (Index v = 0; v < mesh.points.size(); ++v)
    if (weights[v] > 1e-4f) moved_.push_back({v, weights[v]});
}

Motion Jaw::motion(const MotionControls& m, const float* c) {
  const float open = c[m.jaw_open], side = c[m.jaw_side], forward = c[m.jaw_forward];
  // The hinge itself slides forward and down as the jaw opens, and on one side as it swings.
  const Vec3 slide{0.25f * side, -0.15f * open * open, 0.35f * open * open + 0.55f * forward};
  return motion_about(kJawHinge, radians(28) * open * (0.6f + 0.4f * open), radians(6.5f) * side,
                      radians(4) * c[m.jaw_twist] + radians(2) * side * open, slide);
}

void Jaw::pose(const Motion& jaw, Vec3* points) const {
  // The points move by the part of the motion that is not "stay": exactly nothing at rest.
  Motion change = jaw;
  change.rows[0].x -= 1;
  change.rows[1].y -= 1;
  change.rows[2].z -= 1;
  for (const Weighted& w : moved_) points[w.vertex] += change(points[w.vertex]) * w.weight;
}

}  // namespace sample_face
