// Loops round the eyes: socket, crease, lid, edge of the lid and its inside.
#include "anatomy.h"
#include "face_mesh.h"
#include "head_shape.h"

namespace sample_face {
namespace {

// The opening, seen from the eye's centre: half width (cm) and elevations (degrees) of its edge.
constexpr float kHalfWidth = 1.76f;
constexpr float kUpper = 28, kLower = 23, kTilt = 4;

// A ring of the lids: width and height relative to the opening (upper and lower half), and its distance from the eye's
// sphere.
struct LidStep {
  LidRing ring;
  float width, upper, lower, off;
};
constexpr LidStep kSteps[] = {
    {kLidCrease, 1.10f, 1.72f, 1.62f, 0.13f}, {kLidPlate, 1.08f, 1.42f, 1.36f, 0.19f},
    {kLidEdge, 1.05f, 1.14f, 1.12f, 0.205f},  {kLidMargin, 1.00f, 1.00f, 1.00f, 0.17f},
    {kLidBack, 0.98f, 0.99f, 0.99f, 0.05f},   {kLidInner, 1.28f, 1.60f, 1.60f, 0.03f},
};

}  // namespace

float lid_angle(int eye, int column) {
  const float angle = radians(-135 + 11.25f * float(column));  // columns start at the lower left corner
  return eye == 0 ? angle : kPi - angle;
}

void add_lid_loops(FaceMesh& mesh, const Ring& outer, int eye) {
  auto& lids = mesh.lids[eye];
  const float side = eye == 0 ? 1.0f : -1.0f;
  const Vec3 centre = eye_centre(int(side));
  lids[kLidOuter] = outer;
  for (int ring = 1; ring < kLidRings; ++ring) lids[ring].resize(kLidColumns);
  for (const LidStep& step : kSteps)
    for (int i = 0; i < kLidColumns; ++i) {
      const float t = lid_angle(eye, i), c = std::cos(t), s = std::sin(t);
      const float bow = s * (1 - 0.10f * c * (s > 0 ? 1.0f : -1.0f));  // upper arch peaks inside, lower outside
      const float elevation = radians((s > 0 ? kUpper * step.upper : kLower * step.lower) * bow + kTilt * c);
      const float x = std::clamp(kHalfWidth / kEyeRadius * step.width * c, -0.985f, 0.985f);
      const float rho = std::sqrt(1 - x * x);
      const Vec3 direction{side * x, rho * std::sin(elevation), rho * std::cos(elevation)};
      const Vec3 p = centre + direction * (kEyeRadius + cornea_bulge(direction.z) + step.off);
      lids[step.ring][i] = mesh.add(p);
    }
  for (int ring = 1; ring < kLidCrease; ++ring)
    for (int i = 0; i < kLidColumns; ++i) {
      const float t = float(ring) / float(kLidCrease);
      lids[ring][i] = mesh.add(onto_head(mix(mesh.points[outer[i]], mesh.points[lids[kLidCrease][i]], t)));
    }
  for (int ring = 0; ring + 1 < kLidRings; ++ring) mesh.bridge(lids[ring], lids[ring + 1]);
}

}  // namespace sample_face
