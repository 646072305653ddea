#include "anatomy.h"
#include "motion.h"
#include "skin_weights.h"

namespace sample_face {
namespace {

// How much of a segment's fullness each ring takes.
constexpr std::array<float, kLidRings> kSwellFollow = {0, 0.4f, 0.4f, 0.4f, 1, 1, 1, 0, 0};

}  // namespace

Lids::Lids(const FaceMesh& mesh, int eye) : eye_(eye), centre_(eye_centre(eye == 0 ? 1 : -1)), rings_(mesh.lids[eye]) {
  for (int i = 0; i < kLidColumns; ++i) {
    const float angle = lid_angle(eye, i);
    const Vec3 edge = mesh.points[rings_[kLidMargin][i]] - centre_;
    Column& column = columns_[i];
    column.elevation = std::atan2(edge.y, edge.z);
    column.sine = std::sin(angle);
    column.tilt = std::cos(angle);
    // The column with the opposite angle.
    for (int j = 0; j < kLidColumns; ++j)
      if (std::fabs(std::remainder(lid_angle(eye, j) + angle, 2 * kPi)) < 0.01f) column.opposite = j;
    const float at = (1 - column.tilt) * 2.5f - 0.5f;  // segment 0 outside, 4 inside
    for (int s = 0; s < 5; ++s) column.segments[s] = smoothstep(0, 1, 1 - std::fabs(at - float(s)));
    for (int ring = 0; ring < kLidRings; ++ring) {
      const Vec3 d = mesh.points[rings_[ring][i]] - centre_;
      const float r = length(d);
      bulge_[ring][i] = cornea_bulge(d.z / r);
      off_[ring][i] = r - kEyeRadius - bulge_[ring][i];
    }
  }
}

void Lids::pose(const MotionControls& m, const float* c, Vec3 gaze, Vec3 shift, float cheek, Vec3* points) const {
  constexpr float kMeetAt = 0.28f;            // of the opening's height, where the lids meet
  constexpr float kClosest = radians(0.25f);  // between closed lids
  // How far each column of the lids turns about the eye's centre, upwards, and how full it is.
  const float blink = c[m.blink[eye_]], look = std::asin(std::clamp(gaze.y, -1.0f, 1.0f));
  std::array<float, kLidColumns> slide, swell;
  for (int i = 0; i < kLidColumns; ++i) {
    const Column& k = columns_[i];
    const int half = k.sine > 0 ? 0 : 1;
    const float corner = std::min(1.0f, std::fabs(k.sine) * 1.6f);
    const float upper = half == 0 ? k.elevation : columns_[k.opposite].elevation;
    const float lower = half == 0 ? columns_[k.opposite].elevation : k.elevation;
    float up = blink * (mix(lower, upper, kMeetAt) - k.elevation);
    const float tilt = radians(7) * c[m.lid_tilt[eye_]] * k.tilt;
    const float own = half == 0 ? radians(c[m.upper_lid[eye_]] > 0 ? 12 : 26) * c[m.upper_lid[eye_]] + 0.75f * look
                                : radians(13) * c[m.lower_lid[eye_]] + 0.4f * look + radians(9) * cheek;
    float segment_up = 0, segment_full = 0;
    for (int s = 0; s < 5; ++s) {
      segment_up += k.segments[s] * c[m.lid_up[eye_][half][s]];
      segment_full += k.segments[s] * c[m.lid_thick[eye_][half][s]];
    }
    up += (corner * own + radians(7) * corner * segment_up) * (1 - 0.65f * blink) + tilt;
    slide[i] = up;
    swell[i] = 0.12f * segment_full;
  }
  // Lids that would cross meet half way.
  for (int i = 0; i < kLidColumns; ++i) {
    const Column& k = columns_[i];
    if (k.sine <= 0.01f) continue;
    const int j = k.opposite;
    const float rest = k.elevation - columns_[j].elevation;
    const float crossing = std::min(kClosest, rest) - (rest + slide[i] - slide[j]);
    if (crossing > 0) {
      slide[i] += 0.5f * crossing;
      slide[j] -= 0.5f * crossing;
    }
  }
  const Vec3 centre = centre_ + shift;
  for (int ring = 1; ring < kLidRings; ++ring) {
    const float follow = kLidFollow[ring];
    for (int i = 0; i < kLidColumns; ++i) {
      Vec3& p = points[rings_[ring][i]];
      const float angle = slide[i] * follow, s = std::sin(angle), co = std::cos(angle);
      const Vec3 d = p + shift * follow - centre;
      const Vec3 turned{d.x, d.y * co + d.z * s, d.z * co - d.y * s};
      // Off the eyeball as at rest, or further where the skin was drawn out; the cornea pushes the lid before it.
      const float r = length(turned);
      const float under = cornea_bulge(dot(turned, gaze) / r);
      float wanted = std::max(r, kEyeRadius + under);
      if (ring >= kLidCrease)
        wanted = std::max(r + (under - bulge_[ring][i]) * follow,
                          kEyeRadius + under + std::min(off_[ring][i], kLidThickness + 0.05f));
      const float out = wanted - r + swell[i] * kSwellFollow[ring];
      p += (turned - d) + shift * follow + turned * (out / r);
    }
  }
}

}  // namespace sample_face
