// Loops round the mouth: skin, lips, inside of the lips and the bag behind them.
#include "anatomy.h"
#include "face_mesh.h"
#include "head_shape.h"

namespace sample_face {
namespace {

constexpr int kRightCorner = 41;
constexpr int kSegments = kMouthColumns / 2;

// One step of the lips' profile: how far in front of the skin at the mouth line (cm), and how far from the line in
// parts of the lip's height. The second pair is the lower lip's.
struct ProfileStep {
  MouthRing ring;
  float forward_upper, away_upper, forward_lower, away_lower;
};
constexpr ProfileStep kProfile[] = {
    {kLipBorder, 0.04f, 1.00f, 0.02f, 1.00f}, {kLipRise, 0.20f, 0.84f, 0.26f, 0.80f},
    {kLipMiddle, 0.34f, 0.55f, 0.44f, 0.52f}, {kLipFront, 0.33f, 0.17f, 0.38f, 0.16f},
    {kLipSeam, 0.14f, 0.012f, 0.14f, 0.012f}, {kLipInner, -0.22f, 0.06f, -0.22f, 0.06f},
    {kLipBack, -0.55f, 0.55f, -0.55f, 0.55f},
};

// Rings of the bag behind the lips: half width, half height, height of the middle, depth of the middle and how much the
// ring curves round the teeth.
struct BagRing {
  float half_width, half_height, y, z, curve;
};
constexpr BagRing kBag[] = {
    {3.0f, 1.35f, -7.15f, 7.05f, 2.3f}, {3.15f, 1.75f, -7.2f, 6.0f, 2.2f}, {3.1f, 2.0f, -7.3f, 4.5f, 1.6f},
    {2.7f, 2.1f, -7.6f, 2.9f, 0.9f},    {1.8f, 1.6f, -8.0f, 1.2f, 0.3f},
};
static_assert(std::size(kBag) == kMouthRings - kBagFirst);

float upper_height(float across) {  // cupid's bow
  const float a = std::fabs(across);
  return 0.86f * (1 - a * a * a) *
         (1 + 0.22f * std::exp(-std::pow((a - 0.24f) / 0.16f, 2.0f)) - 0.10f * std::exp(-std::pow(a / 0.12f, 2.0f)));
}

float lower_height(float across) {
  return 1.02f * std::pow(1 - across * across, 0.9f);
}

// The line between the lips: falls a little from the middle, rises at the corners.
float line_height(float across) {
  const float a = across * across;
  return kMouthY + 0.05f - 0.24f * a + 0.44f * a * a;
}

}  // namespace

MouthColumn mouth_column(int column) {
  const int n = (column - kRightCorner + kMouthColumns) % kMouthColumns;  // 0 right corner, 22 left corner
  const int steps = n <= kSegments ? n : kMouthColumns - n;               // from the right corner
  const float even = 2 * float(steps) / kSegments - 1;
  const float dense = -std::cos(kPi * float(steps) / kSegments);  // closer together at the corners
  return {mix(even, dense, 0.5f), steps == 0 || steps == kSegments ? 0.0f : (n < kSegments ? -1.0f : 1.0f)};
}

int opposite_column(int column) {
  return (2 * kRightCorner - column) % kMouthColumns;
}

void add_mouth_loops(FaceMesh& mesh, const Ring& outer) {
  std::array<Vec3, kMouthColumns> line, forward;
  for (int i = 0; i < kMouthColumns; ++i) {
    const float across = mouth_column(i).across;
    const Vec3 start{kMouthHalfWidth * across, line_height(across), 14};
    line[i] = hit_head(start, {0, 0, -1});
    line[i].z -= 0.10f * std::pow(std::fabs(across), 6.0f);  // the corners are drawn in
    const Vec3 n = head_normal(line[i]);
    forward[i] = unit({n.x * 0.8f, 0, n.z});
  }
  mesh.mouth[kMouthOuter] = outer;
  for (int ring = 1; ring < kMouthRings; ++ring) mesh.mouth[ring].resize(kMouthColumns);
  for (const ProfileStep& step : kProfile)
    for (int i = 0; i < kMouthColumns; ++i) {
      const MouthColumn c = mouth_column(i);
      const float open = 1 - std::pow(std::fabs(c.across), 4.0f);  // the profile flattens towards the corners
      const float ahead = (c.side > 0 ? step.forward_upper : step.forward_lower);
      const float away =
          c.side > 0 ? step.away_upper * upper_height(c.across) : -step.away_lower * lower_height(c.across);
      Vec3 p = line[i] + forward[i] * (ahead > 0 ? ahead * mix(0.05f, 1.0f, open) : ahead);
      p.y += away;
      if (c.side == 0 && step.ring <= kLipSeam) {
        // At a corner the rings lie one behind the other on the way from the skin to where the lips meet.
        const Vec3 skin = onto_head(line[i] + Vec3{0.14f * c.across, 0.05f, 0});
        p = mix(skin, line[i], float(step.ring - kLipBorder) / float(kLipSeam - kLipBorder));
      } else if (step.ring == kLipBorder || step.ring == kLipRise) {
        const Vec3 skin = onto_head(p);
        p = step.ring == kLipBorder ? skin + head_normal(skin) * 0.03f
                                    : mix(p, skin + forward[i] * (ahead * mix(0.1f, 1.0f, open)), 0.7f);
      }
      mesh.mouth[step.ring][i] = mesh.add(p);
    }
  for (int ring = 1; ring < kLipBorder; ++ring)
    for (int i = 0; i < kMouthColumns; ++i) {
      const float t = float(ring) / float(kLipBorder);
      mesh.mouth[ring][i] = mesh.add(onto_head(mix(mesh.points[outer[i]], mesh.points[mesh.mouth[kLipBorder][i]], t)));
    }
  for (std::size_t r = 0; r < std::size(kBag); ++r)
    for (int i = 0; i < kMouthColumns; ++i) {
      const BagRing& b = kBag[r];
      const MouthColumn c = mouth_column(i);
      const float a = c.across;
      mesh.mouth[kBagFirst + r][i] =
          mesh.add({b.half_width * a, b.y + c.side * b.half_height * std::sqrt(std::max(0.0f, 1 - a * a)),
                    b.z - b.curve * a * a});
    }
  for (int ring = 0; ring + 1 < kMouthRings; ++ring) mesh.bridge(mesh.mouth[ring], mesh.mouth[ring + 1]);
  mesh.throat = mesh.cap(mesh.mouth[kMouthRings - 1], 16, 6);
}

}  // namespace sample_face
