// What lies inside the head's openings: eyeballs, two rows of teeth, the tongue.
#include <algorithm>

#include "anatomy.h"
#include "face_mesh.h"

namespace sample_face {
namespace {

constexpr int kEyeColumns = 32;

// The eyeball's profile from the pupil back: angle from the line of sight, and distance from the bulged sphere. The
// iris is a dish under the cornea's outline with a ring round a deep pupil, so that the look reads without any colour.
struct EyeStep {
  float degrees, off;
};
constexpr EyeStep kEyeProfile[] = {
    {4.0f, -0.62f},  {7.8f, -0.60f},  {9.2f, -0.27f},  {10.6f, -0.24f},  {13.0f, -0.29f},
    {18.0f, -0.24f}, {21.5f, -0.16f}, {23.5f, -0.04f}, {25.5f, -0.005f}, {32.0f, -0.002f},
    {45.0f, 0},      {65.0f, 0},      {90.0f, 0},      {120.0f, 0},      {148.0f, 0},
};

constexpr int kToothColumns = 4;  // per tooth
constexpr int kTeeth = 10;        // in a row

constexpr int kTongueColumns = 16;

}  // namespace

void add_eye(FaceMesh& mesh, int eye) {
  const Vec3 centre = eye_centre(eye == 0 ? 1 : -1);
  const Index first = Index(mesh.points.size());
  Ring previous, front;
  for (const EyeStep& step : kEyeProfile) {
    const float angle = radians(step.degrees), c = std::cos(angle);
    const float radius = kEyeRadius + cornea_bulge(c) + step.off;
    Ring ring;
    for (int i = 0; i < kEyeColumns; ++i) {
      const float turn = 2 * kPi * float(i) / kEyeColumns;
      ring.push_back(mesh.add(centre + Vec3{radius * std::sin(angle) * std::cos(turn),
                                            radius * std::sin(angle) * std::sin(turn), radius * c}));
    }
    if (previous.empty())
      front = ring;
    else
      mesh.bridge(ring, previous);
    mesh.eye_rings[eye].push_back(ring);
    previous = ring;
  }
  mesh.cap(front, 8, 8);
  mesh.cap(Ring(previous.rbegin(), previous.rend()), 8, 8);
  mesh.eyes[eye] = {first, Index(mesh.points.size()) - first};
}

void add_teeth(FaceMesh& mesh, bool upper) {
  const Index first = Index(mesh.points.size());
  const float up = upper ? 1.0f : -1.0f;
  const float width = upper ? 2.25f : 2.1f, front = upper ? 8.0f : 7.5f, biting = kMouthY + (upper ? -0.55f : -0.42f);
  // Section through a tooth: (outwards, towards the gum), all round.
  constexpr std::array<std::array<float, 2>, 8> kSection = {{{0.12f, 1.7f},
                                                             {0.16f, 0.9f},
                                                             {0.14f, 0.35f},
                                                             {0.03f, 0.02f},
                                                             {-0.12f, 0.02f},
                                                             {-0.28f, 0.4f},
                                                             {-0.4f, 1.0f},
                                                             {-0.45f, 1.7f}}};
  constexpr int kColumnsAll = kTeeth * kToothColumns;
  std::vector<Ring> sections;
  for (int i = 0; i <= kColumnsAll; ++i) {
    const float t = 2 * float(i) / kColumnsAll - 1, angle = t * radians(80);
    const Vec3 out{std::sin(angle), 0, std::cos(angle)};
    const Vec3 arch{width * std::sin(angle), biting, front - 3.1f * (1 - std::cos(angle))};
    const float groove = i % kToothColumns == 0 ? 1.0f : 0.0f;  // between two teeth
    Ring ring;
    for (const auto& s : kSection) {
      const float crown = 1 - smoothstep(0.5f, 1.2f, s[1]);
      const float shrink = groove * crown;
      const Vec3 p = arch + out * (s[0] - (s[0] > 0 ? 0.11f : -0.05f) * shrink);
      ring.push_back(mesh.add({p.x, p.y + up * (s[1] + 0.10f * shrink * (s[1] < 0.2f ? 1.0f : 0.0f)), p.z}));
    }
    if (upper) std::reverse(ring.begin(), ring.end());
    sections.push_back(ring);
  }
  for (std::size_t i = 0; i + 1 < sections.size(); ++i) mesh.bridge(sections[i + 1], sections[i]);
  mesh.cap(Ring(sections.front().rbegin(), sections.front().rend()), 2, 2);
  mesh.cap(sections.back(), 2, 2);
  mesh.teeth_rings[upper ? 0 : 1] = sections;
  (upper ? mesh.upper_teeth : mesh.lower_teeth) = Span{first, Index(mesh.points.size()) - first};
}

void add_tongue(FaceMesh& mesh) {
  const Index first = Index(mesh.points.size());
  // Sections from the tip back: centre height and depth, half width, half thickness.
  struct Section {
    float y, z, half_width, half_height;
  };
  constexpr Section kSections[] = {
      {-7.98f, 6.98f, 0.36f, 0.12f}, {-7.97f, 6.86f, 0.72f, 0.22f}, {-7.95f, 6.55f, 1.05f, 0.31f},
      {-7.9f, 6.0f, 1.38f, 0.38f},   {-7.86f, 5.4f, 1.5f, 0.43f},   {-7.82f, 4.8f, 1.56f, 0.48f},
      {-7.8f, 4.2f, 1.6f, 0.53f},    {-7.82f, 3.6f, 1.62f, 0.58f},  {-7.88f, 3.0f, 1.6f, 0.62f},
      {-8.0f, 2.4f, 1.52f, 0.64f},   {-8.2f, 1.8f, 1.35f, 0.6f},
  };
  Ring previous;
  for (const Section& s : kSections) {
    Ring ring;
    for (int i = 0; i < kTongueColumns; ++i) {
      const float turn = 2 * kPi * (float(i) + 0.5f) / kTongueColumns + radians(225) - kPi / kTongueColumns;
      const float c = std::cos(turn), h = std::sin(turn);
      // A groove along the middle of the upper side.
      const float groove = h > 0 ? 0.30f * s.half_height * std::exp(-c * c * 9) : 0.0f;
      ring.push_back(mesh.add({s.half_width * c, s.y + s.half_height * h - groove, s.z}));
    }
    if (previous.empty())
      mesh.cap(ring, 4, 4);
    else
      mesh.bridge(ring, previous);
    mesh.tongue_rings.push_back(ring);
    previous = ring;
  }
  mesh.cap(Ring(previous.rbegin(), previous.rend()), 4, 4);
  mesh.tongue = {first, Index(mesh.points.size()) - first};
}

}  // namespace sample_face
