#include "anatomy.h"
#include "motion.h"

namespace sample_face {
namespace {

// Stops softly at 1.
float soft_limit(float x) {
  return std::tanh(x);
}

constexpr std::array<float, 4> kJoints = {2.2f, 3.6f, 4.8f, 5.9f};      // depths of the tongue's joints at rest
constexpr std::array<float, 4> kDroop = {-0.30f, 0.10f, 0.18f, 0.36f};  // as it comes out, radians a joint
constexpr float kTongueY = -7.95f;

// What the tongue lies on, in the jaw's own space: the floor of the mouth, up over the teeth and the lower lip, and
// down.
float tongue_floor(float z) {
  constexpr float kDeep = -10.5f, kOverLip = -6.95f;
  return mix(kDeep, kOverLip, smoothstep(6.5f, 7.7f, z) * (1 - smoothstep(9.3f, 11.2f, z)));
}

}  // namespace

Eyes::Eyes(const FaceMesh& mesh) : spans_(mesh.eyes) {
  for (int eye = 0; eye < 2; ++eye)
    for (Index i = 0; i < spans_[eye].count; ++i) {
      const Vec3 d = mesh.points[spans_[eye].first + i] - eye_centre(eye == 0 ? 1 : -1);
      const float angle = std::acos(std::clamp(d.z / length(d), -1.0f, 1.0f));
      rest_[eye].push_back(d);
      pupil_[eye].push_back(1 - smoothstep(radians(11), radians(21), angle));
    }
}

Motion Eyes::motion(const MotionControls& m, const float* c, int eye) {
  const float yaw = radians(38) * soft_limit(c[m.look_x] + 0.7f * c[m.eye_yaw[eye]]);
  const float pitch = radians(30) * soft_limit(c[m.look_y] + 0.7f * c[m.eye_pitch[eye]]);
  return motion_about(eye_centre(eye == 0 ? 1 : -1), -pitch, yaw, 0, {0, 0, 0.22f * c[m.eye_out[eye]]});
}

void Eyes::pose(const MotionControls& m, const float* c, const std::array<Motion, 2>& eyes, Vec3* points) const {
  for (int eye = 0; eye < 2; ++eye) {
    const float pupil = 0.45f * c[m.pupil[eye]];
    const bool still = c[m.look_x] == 0 && c[m.look_y] == 0 && c[m.eye_yaw[eye]] == 0 && c[m.eye_pitch[eye]] == 0 &&
                       c[m.eye_out[eye]] == 0 && pupil == 0;
    if (still) continue;
    const Vec3 centre = eye_centre(eye == 0 ? 1 : -1);
    for (Index i = 0; i < spans_[eye].count; ++i) {
      Vec3 d = rest_[eye][i];
      d.x *= 1 + pupil * pupil_[eye][i];
      d.y *= 1 + pupil * pupil_[eye][i];
      points[spans_[eye].first + i] = eyes[eye](centre + d);
    }
  }
}

Tongue::Tongue(const FaceMesh& mesh) : span_(mesh.tongue) {
  rest_.assign(mesh.points.begin() + span_.first, mesh.points.begin() + span_.first + span_.count);
  for (const Vec3& p : rest_) {
    float lowest = p.y;
    for (const Vec3& q : rest_)
      if (std::fabs(q.z - p.z) < 0.01f) lowest = std::min(lowest, q.y);
    above_.push_back(p.y - lowest);
  }
}

void Tongue::pose(const MotionControls& m, const float* c, Vec3* points) const {
  // It waits behind the teeth until the mouth opens.
  const float out = std::min(c[m.tongue_out], 0.08f + 1.6f * c[m.jaw_open]);
  const float wide = 0.25f * c[m.tongue_wide], gutter = 0.35f * c[m.tongue_gutter];
  std::array<Motion, 4> chain;
  Motion parent;
  for (int j = 0; j < 4; ++j) {
    const float turn = radians(24), droop = kDroop[j] * out * out;
    const Vec3 pivot{0, kTongueY, kJoints[j]};
    parent = parent * motion_about(pivot, -turn * c[m.tongue_pitch[j]] + droop, turn * c[m.tongue_yaw[j]],
                                   radians(18) * c[m.tongue_twist]);
    chain[j] = parent;
  }
  for (Index i = 0; i < span_.count; ++i) {
    const Vec3 rest = rest_[i];
    Vec3 p = rest;
    const float along = clamp01((rest.z - kJoints[0]) / (7.0f - kJoints[0]));
    p.x *= 1 + wide * along;
    p.y += gutter * along * (rest.x * rest.x - 0.4f);
    const int joint = rest.z > kJoints[3] ? 3 : rest.z > kJoints[2] ? 2 : rest.z > kJoints[1] ? 1 : 0;
    // Each joint's part begins softly over the end of the part before it.
    const float t = smoothstep(kJoints[joint], kJoints[joint] + 1.1f, rest.z);
    const Vec3 before = joint == 0 ? p : chain[joint - 1](p);
    Vec3 turned = mix(before, chain[joint](p), t);
    // Stretching out: the points run ahead along the way the chain points.
    const Vec3 ahead = joint == 0 ? Vec3{0, 0, 1} : unit(chain[joint].turn({0, 0, 1}));
    turned += ahead * (3.6f * out * along * along) + Vec3{0, 0.95f * out * smoothstep(0.1f, 0.75f, along), 0};
    turned.y = std::max(turned.y, tongue_floor(turned.z) + above_[i]);
    points[span_.first + i] = turned;
  }
}

}  // namespace sample_face
